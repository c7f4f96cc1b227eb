"""Coverage: bigrams that a corpus needs, bigrams that a character has, and bigrams to draw next.

- `coverage` reads lines in one or several languages, for one or several characters.
- `Coverage.to_dict` returns the document from which all other forms are made.

A bigram is *authored* if a bank has it edited or approved. Drafts are not authored, and neither are
bigrams fitted to captures, nor curves that an added phoneme borrows from a similar one.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
