"""Resolve: a language and a character become tables that a performer plays.

Every ordered pair of the language's common phonemes is looked up in layers; the first that has
it wins, and the performer remembers where it came from:

1. the character's own bigrams and banks,
2. the language's banks for this pose set,
3. the pose set's shared banks,
4. the same pair, an added phoneme replaced by what it is `like`, in 1 to 3,
5. a bigram fitted to captures, in 1 to 4,
6. a draft from the phoneme targets of the character, or else of the pose set.

A pair with shades is looked up from the finest pair to the pair of their parents, and drafted only
if none of these is drawn.

What still has none is a gap, named; it is performed as rest only when the caller says so.
"""
