"""Spoken lines of a study, and the pairs of clips of them, in an order that a seed repeats.

A line has a name, a text, and timed phonemes with sound. Pairs have balanced methods and sides.
"""

import random
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from pathlib import Path
from typing import NamedTuple

from lipsync_lang import LipsyncError, Performer, Schedule
from lipsync_lang.base.errors import shortlist
from lipsync_lang.plugins.study.study_file import MAX_PAIRS, ClipSide, StudyPair
from lipsync_lang.text.lines import Line

MAX_STUDY_LINES = 10_000

MAX_LISTED_LINES = 8
"""Maximum number of names in a remark."""

MAX_LINE_NAME_CHARS = 100


@dataclass(frozen=True)
class StudyLine:
    """A line of the clips."""

    name: str
    """Name of the line in the file, or the name of the file with the number of the row."""
    text: str
    """Spoken text; may be empty if there is a schedule."""
    schedule: Schedule | None = None
    """Timed phonemes from the file; None if a voice or an aligner times the text."""
    recording: Path | None = None
    """Recording of the line; None if a voice speaks the text."""


def study_lines(
    found: Iterable[Line],
    texts: Iterable[str] = (),
    recordings: Path | None = None,
    remark: Callable[[str], None] = lambda _: None,
) -> tuple[StudyLine, ...]:
    """Name the lines of a study, and find their recordings.

    The lines of `texts` are named `text_1`, `text_2` and so on. The folder `recordings` has one
    recording per line, with the name of the line; lines without one are left out, and `remark`
    receives their names. Raises LipsyncError if there are no lines or too many, or two lines have
    the same name.
    """
    lines = []
    for line in found:
        if line.text.strip() or line.schedule is not None:
            file, _, row = line.place.rpartition(":")
            own = line.name or f"{Path(file).stem}_{row}"
            lines.append(StudyLine(own[:MAX_LINE_NAME_CHARS], line.text, line.schedule))
    lines += [StudyLine(f"text_{number}", text) for number, text in enumerate(texts, 1)]
    if not lines:
        raise LipsyncError("there is no line to show; name a file of lines, or give a text")
    if len(lines) > MAX_STUDY_LINES:
        raise LipsyncError(f"there are {len(lines)} lines; a study takes at most {MAX_STUDY_LINES}")
    name, count = Counter(line.name for line in lines).most_common(1)[0]
    if count > 1:
        raise LipsyncError(f"{count} lines have the name '{name}'; give each line its own name")
    if recordings is None:
        return tuple(lines)
    files = files_by_stem(recordings)
    without = [line.name for line in lines if line.name not in files]
    if without:
        some = shortlist(without, MAX_LISTED_LINES)
        remark(f"{recordings}: has no recordings with the names {some}; these lines are left out")
    if len(without) == len(lines):
        what = "has no recording with the name of a line; name each recording after its line"
        raise LipsyncError(f"{recordings}: {what}")
    return tuple(
        replace(line, recording=only_file(files[line.name])) for line in lines if line.name in files
    )


def files_by_stem(folder: Path) -> dict[str, list[Path]]:
    """List the visible files of a folder by name without suffix, each list in order."""
    try:
        files = sorted(path for path in folder.iterdir() if path.is_file())
    except OSError as error:
        what = f"cannot be listed: {error.strerror}; check the path"
        raise LipsyncError(f"{folder}: {what}") from None
    found: dict[str, list[Path]] = {}
    for path in files:
        if not path.name.startswith("."):
            found.setdefault(path.name.split(".")[0], []).append(path)
    return found


def only_file(files: list[Path]) -> Path:
    """Return the file of a line; a LipsyncError if it has several."""
    if len(files) > 1:
        names = " and ".join(path.name for path in files[:2])
        raise LipsyncError(f"{files[0].parent}: has {names} for one line; keep one of them")
    return files[0]


def timed(line: StudyLine, performer: Performer, *, engine: str | None = None) -> Schedule:
    """Return the timed phonemes of a line, with its sound; a LipsyncError if that fails."""
    if line.recording is None:
        return line.schedule or performer.speaker.speak(line.text, engine=engine)
    if line.schedule is not None:
        from lipsync_lang.sound.speech.sound import with_sound

        return with_sound(line.schedule, line.recording)
    from lipsync_lang.sound.speech.hearing.alignment import aligned

    return aligned(performer.speaker, line.recording, line.text)


class ClipPair(NamedTuple):
    """Two methods on one line of one character."""

    line: str
    character: str
    methods: tuple[str, str]


def possible_pairs(
    lines: Sequence[str],
    characters: Sequence[str],
    methods: Sequence[str],
    lacks: Callable[[str, str], bool],
) -> Iterator[ClipPair]:
    """Yield every pair of methods on each line and character, unless a method `lacks` the line."""
    for character, line in product(characters, lines):
        there = [method for method in methods if not lacks(method, line)]
        yield from (ClipPair(line, character, pair) for pair in combinations(there, 2))


def in_balanced_order(pairs: Iterable[ClipPair], seed: int) -> Iterator[ClipPair]:
    """Yield the pairs in an order whose first N are balanced, for every N.

    Each next pair has the methods, then the character, then the line with the fewest pairs so far;
    chance decides between equals.
    """
    chance = random.Random(seed)  # noqa: S311 a repeatable order is wanted
    groups: dict[tuple[tuple[str, str], str], list[ClipPair]] = {}
    for pair in pairs:
        groups.setdefault((pair.methods, pair.character), []).append(pair)
    for group in groups.values():
        chance.shuffle(group)
    # Drawn once: chance at each step would make the order of equals depend on all before.
    ties = {key: chance.random() for key in groups}
    methods: Counter[tuple[str, str]] = Counter()
    characters: Counter[str] = Counter()
    lines: Counter[str] = Counter()
    cells: Counter[tuple[tuple[str, str], str]] = Counter()
    while groups:
        key = min(groups, key=lambda k: (methods[k[0]], characters[k[1]], cells[k], ties[k]))
        group = groups[key]
        at = min(range(len(group)), key=lambda n: lines[group[n].line])
        pair = group.pop(at)
        if not group:
            del groups[key]
        methods[pair.methods] += 1
        characters[pair.character] += 1
        cells[key] += 1
        lines[pair.line] += 1
        yield pair


def _turns(pairs: Sequence[ClipPair], chance: random.Random) -> list[bool]:
    """Choose the pairs whose methods change sides: half of those of each character.

    Pairs alternate between characters, so sides that alternate too would be tied to them.
    """
    cells = Counter((pair.methods, pair.character) for pair in pairs)
    turns: dict[tuple[tuple[str, str], str], list[bool]] = {}
    odd: dict[tuple[str, str], bool] = {}
    for (methods, character), count in cells.items():
        own = [False, True] * (count // 2)
        if count % 2:
            own.append(odd.setdefault(methods, chance.random() < 0.5))  # noqa: PLR2004 a coin
            odd[methods] = not odd[methods]
        chance.shuffle(own)
        turns[methods, character] = own
    return [turns[pair.methods, pair.character].pop() for pair in pairs]


def laid_out(pairs: Sequence[ClipPair], checks: int, seed: int) -> tuple[StudyPair, ...]:
    """Return the pairs with sides, and attention checks among them, in random order.

    Each method of a pair is on the left as often as on the right, give or take one, on all
    characters together and on each. Both clips of a check are by the same method. Raises
    LipsyncError if there are too many pairs.
    """
    if len(pairs) + checks > MAX_PAIRS:
        what = f"there are {len(pairs) + checks} pairs with the checks"
        raise LipsyncError(f"{what}; a study has at most {MAX_PAIRS} (`pairs`)")
    # Another seed than that of the order, which would tie sides to lines.
    chance = random.Random(f"{seed} sides")  # noqa: S311 a repeatable choice is wanted
    rows: list[tuple[str, str, str, str, ClipSide | None]] = []
    for pair, turn in zip(pairs, _turns(pairs, chance), strict=True):
        left, right = reversed(pair.methods) if turn else pair.methods
        rows.append((pair.line, pair.character, left, right, None))
    sides: tuple[ClipSide, ClipSide] = ("left", "right")
    first = chance.randrange(2)
    for number in range(checks):
        pair = pairs[number * len(pairs) // checks]
        method, side = pair.methods[0], sides[(first + number // 2) % 2]
        rows.append((pair.line, pair.character, method, method, side))
    chance.shuffle(rows)
    width = max(3, len(str(len(rows))))
    return tuple(
        StudyPair(
            pair=f"p{number:0{width}}", line=line, character=character, left=left, right=right,
            check=check,
        )
        for number, (line, character, left, right, check) in enumerate(rows, 1)
    )  # fmt: skip
