"""Assignment of channels to the shapes of a mesh, across the naming styles of models.

Comparisons run from strict to loose; the first with a result decides. Assigned shapes are not
available to other channels.

1. exact: the channel's name, then an alternative spelling from a pack;
2. folded: case and separators (`_ - . : |` and blanks) are ignored, and L and R equal Left and
   Right. For example, mouthSmileLeft equals MOUTH_SMILE_L, mouth.smile.l and Left_MouthSmile;
3. bare: folded, without a prefix before a dot or colon or one common to most names;
4. pattern: `*` matches any text, longer patterns first. A separator next to the `*` marks the end
   of a word;
5. both sides: without the side, one channel moves both shapes of a pair;
6. shared: both channels of a pair move one shape, with the larger of their values. This is only
   approximate and therefore reported (`Placement.shared`).

Last come the expressions of an avatar (`expressions.py`). A channel that finds no shape by its
name, or one that the expression of its name binds, moves all that this expression binds.

Only the channels of a pair can share a shape. Alternative spellings, patterns and sides can assign
several shapes to a channel; its own name assigns one. Among several candidates the first is taken,
with a report in `Placement.doubts`.
"""

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import lru_cache
from itertools import groupby, islice
from typing import NamedTuple

from lipsync_lang.base.grouping import grouped
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.model import Mesh

_PARTING_MARKS = r"_\-.:|\s"
_NAME_WORD = re.compile(rf"[A-Z]+(?![a-z])|[A-Z]?[^A-Z{_PARTING_MARKS}]+")
_PARTED = re.compile(rf"[{_PARTING_MARKS}]+")
_OWNER = re.compile(r"^.*[.:|]")
_LOOSE_MARKS = re.compile(rf"\*[{_PARTING_MARKS}]|[{_PARTING_MARKS}]\*")
_SIDE_WORDS = {"l": "left", "r": "right", "left": "left", "right": "right"}

NAME, STATED, FOLDED_NAME, FOLDED, BARE_NAME, BARE, PATTERN, BOTH_SIDES, ONE_SIDE = range(9)
"""Comparisons in order, strictest first."""

MANY = {STATED, FOLDED, BARE, PATTERN, BOTH_SIDES}
"""Comparisons that can assign several shapes to a channel."""

MAX_PREFIX_WORDS = 32
"""Maximum number of words of a common prefix, because the time is quadratic in it."""

Grade = tuple[int, int]
"""A comparison and the number of ignored letters; smaller is better."""


@dataclass(frozen=True)
class Placement:
    """Assignment of channels to the shapes of a mesh."""

    shapes: dict[int, list[str]] = field(default_factory=dict)
    """Channel number -> its shapes."""
    shared: dict[str, list[int]] = field(default_factory=dict)
    """Shape without a side -> numbers of the left and right channels that share it."""
    doubts: list[str] = field(default_factory=list)
    """Descriptions of ambiguous assignments."""
    bound: dict[int, dict[str, float]] = field(default_factory=dict)
    """Channel number -> the weights of its shapes, where an expression of an avatar binds them."""


def placed(channels: Sequence[Channel], shapes: Sequence[str]) -> Placement:
    """Assign channels to the shapes of one mesh, bones left out, and describe ambiguities."""
    known = _Index(shapes)
    wanted = grouped(
        (grade, (number, shape))
        for number, channel in enumerate(channels)
        if channel.node is None
        for shape, grade in known.meant_by(channel).items()
    )
    found = Placement()
    taken: set[str] = set()
    for grade in sorted(wanted):
        pairs = [(n, s) for n, s in wanted[grade] if n not in found.shapes and s not in taken]
        found.doubts.extend(_deal(found, grade[0], pairs, [channel.name for channel in channels]))
        taken.update(shape for own in found.shapes.values() for shape in own)
    return found


@lru_cache(maxsize=64)
def on_mesh(channels: tuple[Channel, ...], mesh: Mesh) -> Placement:
    """Assign a model's channels on one mesh; channels bound to that mesh come first.

    All lines of a character share the result, so read it only.
    """
    found = Placement()
    for mine in ({mesh.name, mesh.given} - {None}, {None}):
        numbers = [n for n, channel in enumerate(channels) if channel.mesh in mine]
        taken = {shape for shapes in found.shapes.values() for shape in shapes}
        free = [shape for shape in mesh.shapes if shape not in taken]
        more = placed([channels[n] for n in numbers], free)
        found.shapes.update({numbers[n]: shapes for n, shapes in more.shapes.items()})
        found.shared.update({s: [numbers[n] for n in own] for s, own in more.shared.items()})
        found.doubts.extend(more.doubts)
    stated: dict[str, dict[str, float]] = defaultdict(dict)
    for expression, shape, weight in mesh.binds:
        stated[expression][shape] = weight
    for number, (name, *_) in placed(channels, [*stated]).shapes.items():
        own = found.shapes.get(number, [])
        if not own or stated[name].keys() & set(own):
            found.shapes[number], found.bound[number] = [*stated[name]], stated[name]
    return found


def _deal(
    found: Placement, rule: int, pairs: Sequence[tuple[int, str]], names: Sequence[str]
) -> Iterator[str]:
    """Assign shapes by one comparison; yield descriptions of ambiguities."""
    wanting = grouped((shape, number) for number, shape in pairs)
    for shape, numbers in wanting.items():
        rivals = numbers
        if rule == ONE_SIDE and len({_Spelling.of(names[n]).side for n in numbers}) == len(numbers):
            found.shared[shape] = numbers
            rivals = numbers[:1]
        if len(rivals) > 1:
            others = ", ".join(f"'{names[n]}'" for n in rivals[1:])
            yield f"'{shape}' is used for '{names[rivals[0]]}', but also fits {others}"
    winners = ((n, s) for n, s in pairs if n in found.shared.get(s, wanting[s][:1]))
    for number, group in groupby(winners, key=lambda pair: pair[0]):
        first, *more = (shape for _, shape in group)
        found.shapes[number] = [first, *more] if rule in MANY else [first]
        if more and rule not in MANY:
            alike = ", ".join(f"'{shape}'" for shape in more)
            yield f"'{names[number]}' is '{first}', but {alike} has a similar spelling"


class _Index:
    """Index of a mesh's shapes by their possible names."""

    def __init__(self, shapes: Sequence[str]) -> None:
        self.shapes = shapes
        self.called: dict[str, list[tuple[int, str]]] = defaultdict(list)
        self.sided: dict[str, list[tuple[int, str]]] = defaultdict(list)
        rests: dict[str, list[str]] = defaultdict(list)
        for name in shapes:
            for word in islice(_NAME_WORD.finditer(name), 1, MAX_PREFIX_WORDS + 1):
                rests[name[: word.start()]].append(name[word.start() :])
        # Two prefixes can be dropped: one common to most names, and that of an owner.
        most = {start: own for start, own in rests.items() if 2 * len(own) > len(shapes) > 1}
        shared = [start for start, own in most.items() if any(map(_says, own))]
        for shape in shapes:
            starts = {start for start in shared if shape.startswith(start) and start != shape}
            owner = _OWNER.match(shape)
            if owner is not None and _says(shape[len(owner[0]) :]):
                starts.add(owner[0])
            for start in ("", *sorted(starts, key=len)):
                spelling = _Spelling.of(shape[len(start) :])
                for key in spelling.keys:
                    self.called[key].append((len(start), shape))
                if spelling.side:
                    self.sided[spelling.stem].append((len(start), shape))

    def meant_by(self, channel: Channel) -> dict[str, Grade]:
        """Find candidate shapes for a channel, each with its best grade."""
        stated = [name for name in channel.names if "*" not in name]
        found = [(shape, (NAME, 0)) for shape in self.shapes if shape == channel.name]
        found += [(shape, (STATED, 0)) for shape in self.shapes if shape in stated]
        found += self._spelt(_Spelling.of(channel.name), FOLDED_NAME, BARE_NAME)
        for name in stated:
            found += self._spelt(_Spelling.of(name), FOLDED, BARE)
        for pattern in channel.names:
            if "*" in pattern:
                grade = (PATTERN, -len(pattern))
                found += [(shape, grade) for shape in self.shapes if fits(shape, pattern)]
        best: dict[str, Grade] = {}
        for shape, grade in found:
            best[shape] = min(grade, best.get(shape, grade))
        return best

    def _spelt(self, name: "_Spelling", whole: int, bare: int) -> Iterator[tuple[str, Grade]]:
        """Yield shapes with the same spelling as a name, then shapes of the other side."""
        for key in name.keys:
            for dropped, shape in self.called.get(key, ()):
                yield shape, (bare if dropped else whole, dropped)
        if name.side:
            for dropped, shape in self.called.get(name.stem, ()):
                yield shape, (ONE_SIDE, dropped)
        else:
            for dropped, shape in self.sided.get(name.stem, ()):
                yield shape, (BOTH_SIDES, dropped)


def fits(shape: str, pattern: str) -> bool:
    """Match a shape's name against a pattern with `*` as a wildcard."""
    form = _spaced if _LOOSE_MARKS.search(pattern) else folded
    escaped = re.sub(r"([\[?])", r"[\1]", pattern)
    return fnmatchcase(form(shape), "*".join(map(form, escaped.split("*"))))


def folded(name: str) -> str:
    """Fold a name: remove case and separators."""
    return _PARTED.sub("", unicodedata.normalize("NFKC", name)).casefold()


def _spaced(name: str) -> str:
    """Join a name's words with blanks; mark the word boundaries at its ends."""
    ends = ("" if _PARTED.match(name) is None else " ", " " if _PARTED.search(name[-1:]) else "")
    return ends[0] + " ".join(map(str.casefold, _NAME_WORD.findall(name))) + ends[1]


class _Spelling(NamedTuple):
    """A name split into stem and side."""

    keys: tuple[str, ...]
    """Folded name; for a name with a side, both with the full word and with its letter."""
    stem: str
    """Folded name without its side."""
    side: str
    """Side, left or right; empty if none."""

    @classmethod
    @lru_cache(4096)
    def of(cls, name: str) -> "_Spelling":
        """Split a name into stem and side."""
        text = folded(name)
        words = [*_NAME_WORD.finditer(unicodedata.normalize("NFKC", name))]
        last = len(words) - 1
        # The side is the last word, the first word, or a word that stands alone.
        for number in (last, 0, *range(1, last)) if last > 0 else ():
            side = _SIDE_WORDS.get(words[number][0].casefold())
            alone = not 0 < number < last or (
                words[number].start() > words[number - 1].end()
                and words[number].end() < words[number + 1].start()
            )
            if side is not None and alone:
                stem = "".join(w[0].casefold() for n, w in enumerate(words) if n != number)
                return cls(tuple(dict.fromkeys((text, stem + side, stem + side[0]))), stem, side)
        return cls((text,) if text else (), text, "")


def _says(rest: str) -> bool:
    """Test the remainder of a name for content besides its side."""
    return folded(rest) not in {"", *_SIDE_WORDS}
