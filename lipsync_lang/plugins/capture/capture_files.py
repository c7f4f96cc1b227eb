"""Files of captures, with the timings, texts and sounds that belong to each.

The files of a capture NAME lie side by side: `NAME.csv`, `NAME.TextGrid` or `NAME.phones.tsv`, or
`NAME.txt` and `NAME.wav`. A table with a column `capture` can list them instead.
"""

import os
import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path

from lipsync_lang import LipsyncError
from lipsync_lang.animations.animation_readers import ANIMATION_READERS
from lipsync_lang.animations.readers.json import ANIMATION_MARK
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.base.files import argument_path
from lipsync_lang.base.files.names import folded_name
from lipsync_lang.plugins.capture.fit_file import SetAside
from lipsync_lang.sound.speech.sound import AUDIO_SUFFIXES
from lipsync_lang.text.lines.line_readers import LineFile, is_timed
from lipsync_lang.text.lines.table import open_table

TEXT_SUFFIXES = (".txt", ".lab")
"""Suffixes of texts beside a capture, the most likely first."""

READ_OUT = "readout.yaml"
"""File name of a read-out for the captures in its folder and below."""

HEAD_OF_CAPTURE = 4096
"""Number of first bytes that tell the kind of a file."""

MAX_CAPTURES = 20_000

MAX_WILDCARDS = 4
"""Maximum number of `*` in a pattern, few so that matching is quick."""

LIST_COLUMNS = ("capture", "timings", "text", "audio", "speaker", "start", "fps")
"""Columns of a list of captures; only the first is required."""


@dataclass(frozen=True)
class CaptureFiles:
    """The files of one capture."""

    capture: Path
    name: str
    """The path relative to the searched folder, without suffix."""
    timings: Path | None = None
    text: str | Path | None = None
    """The spoken text, or a text file."""
    audio: Path | None = None
    speaker: str = ""
    start: float = 0.0
    """Start of the capture in seconds, on the clock of the timings."""
    fps: float | None = None
    """Frames per second as stated in the list."""
    readout: Path | None = None
    """The read-out of its folder."""


def find_captures(
    paths: str | Path | Iterable[str | Path], *, speaker: str | None = None
) -> tuple[tuple[CaptureFiles, ...], list[SetAside]]:
    """Find the captures among files and below folders, and those that cannot be used.

    `speaker` is a pattern of names with the speaker, such as `{speaker}_*`, or of paths below the
    folder, such as `*/{speaker}/*`; by default, the speaker is the first folder below the searched
    one.
    """
    pattern = None
    if speaker is not None:  # `*` is any text, `{speaker}` the speaker
        before, mark, after = speaker.partition("{speaker}")
        if not mark or speaker.count("*") > MAX_WILDCARDS or "{speaker}" in after:
            raise LipsyncError(
                f"{speaker}: a pattern has `{{speaker}}` once and at most four `*`, as in "
                "`{speaker}_*`"
            )
        # Few wildcards: a pattern with many `.*` takes exponential time on long names.
        parts = (".*".join(map(re.escape, part.split("*"))) for part in (before, after))
        pattern = re.compile("([^/]+?)".join(parts))
    found: dict[str, CaptureFiles] = {}
    aside: list[SetAside] = []
    for path in map(argument_path, [paths] if isinstance(paths, (str, Path)) else paths):
        if not path.exists():
            raise LipsyncError(f"{path}: no such file or folder; check the path")
        folder = path.parent
        listed: Iterable[CaptureFiles]
        if path.is_dir():
            listed = _below(path, aside)
        elif _lists_captures(path):
            listed = _stated(path, _Neighbours(folder), folder, aside)
        else:
            listed = [_Neighbours(folder).files_of(path, folder)]
        for one in listed:
            found.setdefault(os.path.realpath(one.capture), one)
        if len(found) > MAX_CAPTURES:
            raise LipsyncError(f"{path}: holds more than {MAX_CAPTURES} captures; give fewer")
    if not found and not aside:
        places = str(paths) if isinstance(paths, (str, Path)) else ", ".join(map(str, paths))
        raise LipsyncError(
            f"no captures in {places}; known: {', '.join(ANIMATION_READERS.suffixes())}"
        )
    return tuple(_uniquely_named(found.values(), pattern)), aside


def _uniquely_named(
    found: Collection[CaptureFiles], pattern: re.Pattern[str] | None
) -> Iterator[CaptureFiles]:
    """Yield captures with their speakers, and with suffixes that distinguish equal names."""
    counts = Counter(one.name for one in found)
    seen: Counter[str] = Counter()
    for one in found:
        speaker = one.speaker
        if not speaker and pattern is None:
            speaker = one.name.partition("/")[0] if "/" in one.name else ""
        elif not speaker and pattern is not None:
            last = one.name.rpartition("/")[2]
            matched = pattern.fullmatch(one.name) or pattern.fullmatch(last)
            speaker = matched[1] if matched else ""
        name = one.name if counts[one.name] == 1 else f"{one.name}{one.capture.suffix}"
        seen[name] += 1
        own = name if seen[name] == 1 else f"{name}-{seen[name]}"
        yield replace(one, speaker=speaker, name=own)


def _below(root: Path, aside: list[SetAside]) -> Iterator[CaptureFiles]:
    """Yield the captures below a folder in order, with the fields of the tables that list them."""
    beside: list[CaptureFiles] = []
    for at, folders, names in os.walk(root):
        # `os.walk` descends in the order of this list.
        folders.sort()
        here = Path(at)
        folder = _Neighbours(here, names)
        for name in sorted(names):
            path = here / name
            if _lists_captures(path):
                yield from _stated(path, folder, root, aside)
            elif folder.is_capture(path):
                beside.append(folder.files_of(path, root))
        if len(beside) > MAX_CAPTURES:
            raise LipsyncError(f"{root}: holds more than {MAX_CAPTURES} captures; give fewer")
    yield from beside  # last, because the first of equal captures is kept


def _head(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            return stream.read(HEAD_OF_CAPTURE).decode("utf-8-sig", "ignore")
    except OSError:
        return ""


def _lists_captures(path: Path) -> bool:
    """Test a file for a table with a column `capture`."""
    if path.suffix.lower() not in {".csv", ".tsv"}:
        return False
    first = _head(path).partition("\n")[0]
    return LIST_COLUMNS[0] in [one.strip(' "\r').casefold() for one in re.split("[\t,;|]", first)]


def _stated(
    path: Path, folder: "_Neighbours", root: Path, aside: list[SetAside]
) -> Iterator[CaptureFiles]:
    """Yield the captures that a table lists; a faulty row is set aside."""
    source = LineFile(path, lambda _: None)
    table = open_table(source)
    head = [name.casefold() for name in table.head]
    unknown = next((name for name in head if name and name not in LIST_COLUMNS), None)
    if unknown is not None:
        raise source.fault(1, f"unknown column '{unknown}'; {did_you_mean(unknown, LIST_COLUMNS)}")
    for number, row in table.rows:
        cells = {
            name: cell.strip() for name, cell in zip_longest(head, row[: len(head)], fillvalue="")
        }
        if not any(cells.values()):
            continue
        try:
            stated = [what for what in ("capture", "timings", "audio") if cells.get(what)]
            files = {what: _inside(path.parent, cells[what]) for what in stated}
            if "capture" not in files:
                raise LipsyncError("the first column is empty; write the capture there")  # noqa: TRY301
            one = folder.files_of(files["capture"], root)
            if cells.get("text") or "timings" in files:
                one = replace(one, timings=files.get("timings"), text=cells.get("text") or None)
            start, fps = _number(cells, "start", 0.0), _number(cells, "fps", None)
            audio, speaker = files.get("audio", one.audio), cells.get("speaker", "")
            yield replace(one, audio=audio, speaker=speaker, start=start, fps=fps)
        except LipsyncError as error:
            place = f"{path}:{number}"
            aside.append(SetAside(line=cells[LIST_COLUMNS[0]] or place, why=f"{place}: {error}"))


def _inside(folder: Path, name: str) -> Path:
    """Return a listed file, which must be below the folder of the list."""
    path = folder / name
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise LipsyncError(f"'{name}' is outside the folder of the list; move the file into it")
    try:
        there = path.is_file()
    except (OSError, ValueError):  # longer than any name, or with a zero byte
        there = False
    if not there:
        raise LipsyncError(f"there is no file '{name}'; check the path")
    return path


def _number(cells: dict[str, str], what: str, usual: float | None) -> float:
    text = cells.get(what)
    if not text:
        return usual  # type: ignore[return-value]  # None for a rate that nobody states
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not abs(number) < 86_400 or (what == "fps" and number <= 0):  # noqa: PLR2004 a day
        raise LipsyncError(f"`{what}` is '{text[:20]}'; write a number, such as 2.5")
    return number


class _Neighbours:
    """The files of a folder, by the name that captures and their neighbours share."""

    def __init__(self, folder: Path, names: Iterable[str] | None = None) -> None:
        self.folder = folder
        listed = os.listdir(folder) if names is None else names  # noqa: PTH208 names are enough
        self.by_stem: dict[str, list[str]] = defaultdict(list)
        self._captures: dict[str, bool] = {}
        captures: Counter[str] = Counter()
        for name in sorted(listed):
            stem = name.rpartition(".")[0] or name
            # `NAME.phones.tsv` belongs to NAME as well as to `NAME.phones`.
            for key in dict.fromkeys((stem, stem.partition(".")[0])):
                self.by_stem[folded_name(key)].append(name)
            if self.is_capture(folder / name):
                captures[folded_name(stem.partition(".")[0])] += 1
        self._shared = {base for base, count in captures.items() if count > 1}

    def is_capture(self, path: Path) -> bool:
        """Distinguish captures from timings by their content."""
        if path.name not in self._captures:
            suffix = path.suffix.lower()
            if suffix not in ANIMATION_READERS.suffixes() or _lists_captures(path):
                motion = False
            else:
                marked = suffix == ".json" and ANIMATION_MARK in _head(path)
                motion = marked or not _is_timings(path)
            self._captures[path.name] = motion
        return self._captures[path.name]

    def files_of(self, capture: Path, root: Path) -> CaptureFiles:
        """Return a capture with its neighbours; the full stem precedes the name up to a dot."""
        stem = capture.name.rpartition(".")[0] or capture.name
        base = stem.partition(".")[0]
        # If two captures share the name up to the dot, its files may belong to either of them.
        keys = [stem] if folded_name(base) in self._shared else list(dict.fromkeys((stem, base)))
        near = [name for key in keys for name in self.by_stem.get(folded_name(key), ())]
        beside = [self.folder / name for name in near if name != capture.name]
        timed = [path for path in beside if _is_timings(path)]
        told = (p for suffix in TEXT_SUFFIXES for p in beside if p.suffix.lower() == suffix)
        heard = (p for suffix in AUDIO_SUFFIXES for p in beside if p.suffix.lower() == suffix)
        name = capture.with_name(base if base not in self._shared else stem)
        shown = name.relative_to(root) if name.is_relative_to(root) else Path(name.name)
        above = [capture.parent, *capture.parent.parents]
        above = above[: above.index(root) + 1] if root in above else above
        return CaptureFiles(
            capture,
            shown.as_posix(),
            timed[0] if timed else None,
            next((path for path in told if path not in timed), None),
            next(heard, None),
            readout=next((at / READ_OUT for at in above if (at / READ_OUT).is_file()), None),
        )


def _is_timings(path: Path) -> bool:
    return is_timed(LineFile(path, lambda _: None))
