r"""Contexts of spelling rules: regular expressions with a limit on their running time.

Packs come from strangers, and `re` has no time limit. Two limits replace a clock:

- a context sees at most ``SEEN_LETTERS`` letters before or after the rule's spelling,
- ``MAX_MATCH_STEPS`` bounds the steps of a backtracking engine over those letters.

The number of steps follows from the expression. Alternatives add their ways to match. Parts in
sequence multiply them, because each way of one part is tried with each way of the next.
Lookarounds, atomic groups and possessive repeats match in one way: the engine never backtracks
into them. A group with one way may repeat without limit. A group with several ways would take
exponential time, and is refused.

The text is folded (composed, in small letters), so literals are folded too. Escapes, names of
groups and sets are left as they are, and the expression ignores case.
"""

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple, Self
from unicodedata import normalize

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.text.phonology.g2p.tokens import APOSTROPHES, plain

SEEN_LETTERS = 50
"""Maximum number of letters of a word for a context."""

MAX_MATCH_STEPS = 2_000_000
"""Maximum number of steps of one match in a word: some hundredths of a second."""

MAX_STEPS_PER_LETTER = 50_000_000
"""Maximum number of steps of all rules at one letter of a word."""

MAX_CONTEXT_CHARS = 1_000
"""Maximum length of a context, in characters."""

_TOO_MANY = MAX_MATCH_STEPS + 1
_GROUP_STARTS = ("(?=", "(?!", "(?<", "(?>")

_CONTEXT_TOKEN = re.compile(
    r"(?P<escape>\\(?:.|\Z))"
    r"|(?P<set>\[\^?\]?(?:\\.|[^\]\\])*+\])"
    r"|(?P<named>\(\?P=\w+\))"
    r"|(?P<opening>\((?:\?(?:[:=!>]|<[=!]|P<\w+>))?)"
    r"|(?P<closing>\))"
    r"|(?P<repeat>(?:[*+?]|\{(?:\d+|\d*,\d*)\})[?+]?)"
    r"|(?P<either>\|)"
    r"|(?P<mark>[$^.])"
    r"|(?P<literal>(?:[^\\\[\](){}*+?|$^.]|\](?!\])|[{}])[\u0300-\u036f]*+|.)",
    re.DOTALL,
)
"""The parts of a regular expression; a letter carries its combining marks."""

_FLAG_LIKE = re.compile(r"\(\?[^)]{0,20}")
_SET_ALGEBRA = re.compile(r"(?<!\\)\[|--|&&|~~|\|\|")


class ContextError(ValueError):
    """A context cannot be used: `what` is the mistake, `cure` how to mend it, if anything can.

    `slow` is True if the context is valid but could take too long.
    """

    def __init__(self, what: str, cure: str = "", *, slow: bool = False) -> None:
        super().__init__(f"{what}; {cure}" if cure else what)
        self.what = what
        self.cure = cure
        self.slow = slow


class Context(NamedTuple):
    """A condition on the letters before or after the spelling of a rule.

    `steps` are the most steps of the engine for one match. With `precedes`, the match must end at
    the spelling.
    """

    pattern: re.Pattern[str]
    precedes: bool
    steps: int

    def fits(self, word: str, at: int) -> bool:
        """Return True if the context fits at a place of a folded word.

        With `precedes`, the letters before `at` are matched, otherwise those from `at` on.
        """
        if self.precedes:
            return bool(self.pattern.search(word, max(0, at - SEEN_LETTERS), at))
        return bool(self.pattern.match(word, at, at + SEEN_LETTERS))


class Surroundings(NamedTuple):
    """Contexts on both sides of some letters; `before` is for what follows them."""

    before: Context | None
    after: Context | None

    def fit(self, word: str, start: int, stop: int) -> bool:
        """Return True if both contexts fit letters between two places of a folded word."""
        return (self.before is None or self.before.fits(word, stop)) and (
            self.after is None or self.after.fits(word, start)
        )

    @classmethod
    def compiled(cls, before: str, after: str, where: str) -> Self:
        """Compile contexts as a pack states them; an empty one fits. Errors begin with `where`."""
        try:
            return cls(
                compile_context(before, precedes=False) if before else None,
                compile_context(after, precedes=True) if after else None,
            )
        except ContextError as error:
            raise SpeechError(f"{where} {error}") from None


@lru_cache(4096)
def compile_context(text: str, *, precedes: bool) -> Context:
    r"""Compile a context; the result works on every word.

    Raise `ContextError` for a text that is not a regular expression, uses a feature that contexts
    lack, or is too slow.

    >>> compile_context("[ei]|$", precedes=False).fits("cena", 1)
    True
    """
    if len(text) > MAX_CONTEXT_CHARS:
        what = f"has {len(text)} characters of at most {MAX_CONTEXT_CHARS}"
        raise ContextError(what, "state several rules", slow=True)
    parts = list(_parts(text))
    folded = "".join(_folded(kind, part) for kind, part in parts)
    try:
        with warnings.catch_warnings():
            # Python warns of expressions that its later versions will read otherwise.
            warnings.simplefilter("error")
            pattern = re.compile(folded, re.IGNORECASE)  # alone first: ")(" closes the group below
            if precedes:
                pattern = re.compile(rf"(?:{folded})\Z", re.IGNORECASE)
    except (re.error, RecursionError, OverflowError, Warning) as error:
        raise ContextError(f"is not a regular expression: {error}") from None
    steps = _steps(parts) * (SEEN_LETTERS if precedes else 1)  # a search starts at each letter
    if steps > MAX_MATCH_STEPS:
        raise ContextError(
            "could take too long, because it may match the same letters in too many ways",
            "use fewer repeats, or possessive ones that give nothing back, as in [ab]*+",
            slow=True,
        )
    return Context(pattern, precedes, steps)


def _parts(text: str) -> Iterator[tuple[str, str]]:
    """Yield (kind, part) along a regular expression; raise an error for unsupported features."""
    for found in _CONTEXT_TOKEN.finditer(text):
        kind, part = str(found.lastgroup), found[0]
        if kind == "opening" and part == "(" and text.startswith("(?", found.start()):
            shown = _FLAG_LIKE.match(text, found.start())
            raise ContextError(
                f"'{shown[0] if shown else part}' is not available in contexts",
                "groups are ( ), (?: ), (?= ), (?! ), (?<= ), (?<! ), (?> ) and (?P<name> )",
            )
        yield kind, part


def _folded(kind: str, part: str) -> str:
    """Return a part of an expression in folded form, to match folded text."""
    if kind == "literal":
        return plain(part)
    if kind != "set":
        return part
    if _SET_ALGEBRA.search(part[1:]):
        raise ContextError(
            f"the set '{part}' holds '[', '--', '&&', '~~' or '||'",
            "put a backslash before the first of them",
        )
    composed = normalize("NFC", part).translate(APOSTROPHES)
    for letter in composed:
        if len(normalize("NFC", letter.casefold())) > 1:
            raise ContextError(
                f"'{letter}' in the set '{part}' is {len(letter.casefold())} letters, "
                f"'{letter.casefold()}', once words are in small letters",
                f"take it out of the set, and write (?:{letter}|[...])",
            )
    return composed


class _Cost(NamedTuple):
    """The worst-case cost of a part: matches that backtracking can try, and steps to try all."""

    ways: int = 1
    steps: int = 0
    group: bool = False


@dataclass
class _Group:
    """A group during parsing: finished alternatives, and the current one."""

    opened: str = "("
    ways: int = 0
    steps: int = 0
    here: _Cost = field(default_factory=_Cost)
    last: _Cost = field(default_factory=_Cost)

    def add(self, item: _Cost) -> None:
        """Add an item, and finish the item before, which a repeat could still have changed."""
        ways = min(self.here.ways * self.last.ways, _TOO_MANY)
        steps = min(self.here.steps + self.here.ways * self.last.steps, _TOO_MANY)
        self.here, self.last = _Cost(ways, steps), item

    def next_alternative(self) -> None:
        """Finish the current alternative."""
        self.add(_Cost())
        self.ways, self.steps = self.ways + self.here.ways, self.steps + self.here.steps
        self.here = _Cost()

    def total(self) -> _Cost:
        """Return the cost of the group; lookarounds and atomic groups match in one way."""
        self.next_alternative()
        whole = self.opened.startswith(_GROUP_STARTS)
        return _Cost(1 if whole else self.ways, self.steps, group=True)


def _steps(parts: list[tuple[str, str]]) -> int:
    """Return the maximum number of steps of a well-formed expression from one start."""
    groups = [_Group()]
    for kind, part in parts:
        here = groups[-1]
        if kind == "opening":
            groups.append(_Group(part))
        elif kind == "closing":
            groups.pop()
            groups[-1].add(here.total())
        elif kind == "either":
            here.next_alternative()
        elif kind == "repeat":
            here.last = _repeated(here.last, part)
        else:
            here.add(_Cost(1, 1))
    return groups[0].total().steps


def _repeated(item: _Cost, repeat: str) -> _Cost:
    """Return the cost of an item under a repeat."""
    bounds = {"*": "0,", "+": "1,", "?": "0,1"}.get(repeat[0]) or repeat[1 : repeat.index("}")]
    start, comma, end = bounds.partition(",")
    least = int(start or 0)
    most = int(end) if end else None if comma else least
    if most is None and item.ways > 1:
        raise ContextError(
            f"repeats a group ('){repeat}') that may match the same letters in several ways, "
            "which could take too long",
            "make the group atomic, as in (?>...)*, or repeat a set of letters, as in [ab]*",
            slow=True,
        )
    times = SEEN_LETTERS if most is None else most
    if not item.group:  # letters run out
        times, least = min(times, SEEN_LETTERS), min(least, SEEN_LETTERS)
    # Without this, the loop below counts to a number such as `{9999999}`.
    if times > MAX_MATCH_STEPS:
        return _Cost(_TOO_MANY, _TOO_MANY, item.group)
    steps = ways = 0
    tried = 1
    for count in range(times + 1):
        ways = min(ways + tried, _TOO_MANY) if count >= least else ways
        steps = min(steps + tried * item.steps, _TOO_MANY)
        tried = min(tried * item.ways, _TOO_MANY)
        if steps >= _TOO_MANY:
            break
    whole = repeat.endswith("+") and len(repeat) > 1
    return _Cost(1 if whole else max(ways, 1), steps, item.group)
