"""Which shapes of a mesh channels mean, however a model spells them.

The strictest comparison that finds something decides; what it finds is no longer free for others.

1. the channel's name, letter by letter; then a spelling of it that a pack states;
2. the same folded: capitals, and what parts words (`_ - . : |` and blanks), are nothing, and L and
   R are Left and Right. So mouthSmileLeft is MOUTH_SMILE_L, mouth.smile.l and Left_MouthSmile;
3. the same without what stands before a dot or colon, or a beginning that most names share;
4. a pattern, in which `*` stands for anything; a longer one before a shorter one. Where a sign that
   parts words stands beside the `*`, a word ends there;
5. the same without its side: one channel moves both shapes of a pair;
6. the other way round: both channels of a pair move one shape, which is only about right, so it is
   reported (`Placement.shared`). Of their two values the larger counts.

Only the channels of a pair ever share a shape. A channel is several shapes where spellings that a
pack states, a pattern or a side say so, but one by its own name. Where more would fit, the first is
taken, and that is reported too (`Placement.doubts`).
"""

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from functools import lru_cache
from itertools import groupby
from typing import NamedTuple

from lipsync_lang.rigs.channel import Channel
from lipsync_lang.rigs.model import Mesh

_PARTING = r"_\-.:|\s"
_WORD = re.compile(rf"[A-Z]+(?![a-z])|[A-Z]?[^A-Z{_PARTING}]+")
_PARTED = re.compile(rf"[{_PARTING}]+")
_OWNER = re.compile(r"^.*[.:|]")
_LOOSE = re.compile(rf"\*[{_PARTING}]|[{_PARTING}]\*")
_SIDES = {"l": "left", "r": "right", "left": "left", "right": "right"}

NAME, STATED, FOLDED_NAME, FOLDED, BARE_NAME, BARE, PATTERN, BOTH_SIDES, ONE_SIDE = range(9)
"""The comparisons, strictest first."""

MANY = {STATED, FOLDED, BARE, PATTERN, BOTH_SIDES}
"""Those by which a channel may be several shapes."""

Grade = tuple[int, int]
"""A comparison, and how much of a name it leaves out; the least is the best."""


@dataclass(frozen=True)
class Placement:
    """Where channels are among the shapes of a mesh."""

    shapes: dict[int, list[str]] = field(default_factory=dict)
    """Number of a channel -> the shapes that it means."""
    shared: dict[str, list[int]] = field(default_factory=dict)
    """A shape without a side -> the numbers of the channels that have one."""
    doubts: tuple[str, ...] = ()
    """What else could be meant, in words."""


def places(channels: Sequence[Channel], shapes: Sequence[str]) -> dict[int, list[str]]:
    """Return, for each channel number, the shapes of one mesh that it means."""
    return placed(channels, shapes).shapes


def placed(channels: Sequence[Channel], shapes: Sequence[str]) -> Placement:
    """Place channels among the shapes of one mesh, and say what is doubtful.

    Parameters
    ----------
    channels : those of bones are nowhere
    shapes : names, each once
    """
    known = _Index(shapes)
    wanted: dict[Grade, list[tuple[int, str]]] = defaultdict(list)
    for number, channel in enumerate(channels):
        if channel.node is None:
            for shape, grade in known.meant_by(channel).items():
                wanted[grade].append((number, shape))
    found = Placement()
    taken: set[str] = set()
    doubts: list[str] = []
    for grade in sorted(wanted):
        pairs = [(n, s) for n, s in wanted[grade] if n not in found.shapes and s not in taken]
        doubts += _deal(found, grade[0], pairs, [channel.name for channel in channels])
        taken.update(shape for own in found.shapes.values() for shape in own)
    return Placement(found.shapes, found.shared, tuple(doubts))


def on_mesh(channels: Sequence[Channel], mesh: Mesh) -> Placement:
    """Place a model's channels on one of its meshes; those that name the mesh come first."""
    found = Placement()
    for mine in ({mesh.name, mesh.given} - {None}, {None}):
        numbers = [n for n, channel in enumerate(channels) if channel.mesh in mine]
        taken = {shape for shapes in found.shapes.values() for shape in shapes}
        free = [shape for shape in mesh.shapes if shape not in taken]
        more = placed([channels[n] for n in numbers], free)
        found.shapes.update({numbers[n]: shapes for n, shapes in more.shapes.items()})
        found.shared.update({s: [numbers[n] for n in own] for s, own in more.shared.items()})
        found = replace(found, doubts=found.doubts + more.doubts)
    return found


def _deal(
    found: Placement, rule: int, pairs: Sequence[tuple[int, str]], names: Sequence[str]
) -> Iterator[str]:
    """Give shapes to the channels that want them by one comparison; yield what is doubtful."""
    wanting: dict[str, list[int]] = defaultdict(list)
    for number, shape in pairs:
        wanting[shape].append(number)
    for shape, numbers in wanting.items():
        rivals = numbers
        if rule == ONE_SIDE and len({_Spelt.of(names[n]).side for n in numbers}) == len(numbers):
            found.shared[shape] = numbers
            rivals = numbers[:1]
        if len(rivals) > 1:
            others = ", ".join(f"'{names[n]}'" for n in rivals[1:])
            yield f"'{shape}' is taken for '{names[rivals[0]]}', but fits {others} as well"
    winners = ((n, s) for n, s in pairs if n in found.shared.get(s, wanting[s][:1]))
    for number, group in groupby(winners, key=lambda pair: pair[0]):
        first, *more = (shape for _, shape in group)
        found.shapes[number] = [first, *more] if rule in MANY else [first]
        if more and rule not in MANY:
            alike = ", ".join(f"'{shape}'" for shape in more)
            yield f"'{names[number]}' is taken to be '{first}', but {alike} is spelled alike"


class _Index:
    """The shapes of a mesh, by what each of them may be called."""

    def __init__(self, shapes: Sequence[str]) -> None:
        self.shapes = shapes
        self.called: dict[str, list[tuple[int, str]]] = defaultdict(list)
        self.sided: dict[str, list[tuple[int, str]]] = defaultdict(list)
        for shape, dropped, rest in _variants(shapes):
            spelt = _Spelt.of(rest)
            for key in spelt.keys:
                self.called[key].append((dropped, shape))
            if spelt.side:
                self.sided[spelt.stem].append((dropped, shape))

    def meant_by(self, channel: Channel) -> dict[str, Grade]:
        """Return the shapes that a channel may mean, each with the best grade that it has."""
        best: dict[str, Grade] = {}
        for shape, grade in self._meant(channel):
            best[shape] = min(grade, best.get(shape, grade))
        return best

    def _meant(self, channel: Channel) -> Iterator[tuple[str, Grade]]:
        stated = [name for name in channel.names if "*" not in name]
        yield from ((s, (NAME, 0)) for s in self.shapes if s == channel.name)
        yield from ((s, (STATED, 0)) for s in self.shapes if s in stated)
        yield from self._spelt(_Spelt.of(channel.name), FOLDED_NAME, BARE_NAME)
        for name in stated:
            yield from self._spelt(_Spelt.of(name), FOLDED, BARE)
        for pattern in channel.names:
            if "*" in pattern:
                grade = (PATTERN, -len(pattern))
                yield from ((shape, grade) for shape in self.shapes if fits(shape, pattern))

    def _spelt(self, name: "_Spelt", whole: int, bare: int) -> Iterator[tuple[str, Grade]]:
        """Yield the shapes that are spelled as a name is, and those that are so but for a side."""
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
    """Tell whether a shape's name is of a pattern, in which `*` stands for anything."""
    form = _spaced if _LOOSE.search(pattern) else folded
    escaped = re.sub(r"([\[?])", r"[\1]", pattern)
    return fnmatchcase(form(shape), "*".join(map(form, escaped.split("*"))))


def folded(name: str) -> str:
    """Return a name without capitals, and without what parts its words."""
    return _PARTED.sub("", unicodedata.normalize("NFKC", name)).casefold()


def _spaced(name: str) -> str:
    """Return a name's words with blanks between them, and where it begins or ends in one."""
    ends = ("" if _PARTED.match(name) is None else " ", " " if _PARTED.search(name[-1:]) else "")
    return ends[0] + " ".join(map(str.casefold, _WORD.findall(name))) + ends[1]


class _Spelt(NamedTuple):
    """A name, taken apart."""

    keys: tuple[str, ...]
    """It folded; with a side, in full and by its letter."""
    stem: str
    """It folded, without a side."""
    side: str
    """Left or right, if it says so; else empty."""

    @classmethod
    @lru_cache(4096)
    def of(cls, name: str) -> "_Spelt":
        """Take a name apart."""
        text = folded(name)
        words = [*_WORD.finditer(unicodedata.normalize("NFKC", name))]
        for number in _places_of_sides(words):
            side = _SIDES[words[number][0].casefold()]
            stem = "".join(w[0].casefold() for n, w in enumerate(words) if n != number)
            return cls(tuple(dict.fromkeys((text, stem + side, stem + side[0]))), stem, side)
        return cls((text,) if text else (), text, "")


def _places_of_sides(words: Sequence["re.Match[str]"]) -> Iterator[int]:
    """Yield which words may say the side: the last one, the first one, one that stands alone."""
    if len(words) < 2:  # noqa: PLR2004 a side of nothing
        return
    last = len(words) - 1
    for number in (last, 0, *range(1, last)):
        alone = (
            words[number].start() > words[number - 1].end()
            and words[number].end() < words[number + 1].start()
            if 0 < number < last
            else True
        )
        if alone and words[number][0].casefold() in _SIDES:
            yield number


def _variants(shapes: Sequence[str]) -> Iterator[tuple[str, int, str]]:
    """Yield each shape, how many letters of it are dropped, and what remains."""
    shared = _shared(shapes)
    for shape in shapes:
        yield shape, 0, shape
        starts = {start for start in shared if shape.startswith(start) and start != shape}
        owner = _OWNER.match(shape)
        if owner is not None and _says(shape[len(owner[0]) :]):
            starts.add(owner[0])
        for start in sorted(starts, key=len):
            yield shape, len(start), shape[len(start) :]


def _shared(names: Sequence[str]) -> list[str]:
    """Return what most of a model's names begin with, up to the end of a word."""
    rests: dict[str, list[str]] = defaultdict(list)
    for name in names:
        for word in [*_WORD.finditer(name)][1:]:
            rests[name[: word.start()]].append(name[word.start() :])
    most = {start: own for start, own in rests.items() if 2 * len(own) > len(names) > 1}
    return [start for start, own in most.items() if any(map(_says, own))]


def _says(rest: str) -> bool:
    """Tell whether what is left of a name is more than its side."""
    return folded(rest) not in {"", *_SIDES}
