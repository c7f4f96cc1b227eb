"""Spoken lines of a study: their names, texts and timed phonemes with sound."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.errors import LipsyncError, shortlist

if TYPE_CHECKING:
    from lipsync_lang.lines import Line
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.schedules.schedule import Schedule

MAX_STUDY_LINES = 10_000
"""Maximum number of lines to choose from."""

MAX_LISTED_LINES = 8
"""Maximum number of names in a remark."""

MAX_LINE_NAME_CHARS = 100
"""Maximum length of a line's name."""


@dataclass(frozen=True)
class StudyLine:
    """A line of the clips."""

    name: str
    """Name of the line in the file, or the name of the file with the number of the row."""
    text: str
    """Spoken text; may be empty if there is a schedule."""
    schedule: "Schedule | None" = None
    """Timed phonemes from the file; None if a voice or an aligner times the text."""
    recording: Path | None = None
    """Recording of the line; None if a voice speaks the text."""


def study_lines(
    found: "Iterable[Line]",
    texts: Iterable[str] = (),
    recordings: Path | None = None,
    remark: Callable[[str], None] = lambda _: None,
) -> tuple[StudyLine, ...]:
    """Name the lines of a study, and find their recordings.

    Parameters
    ----------
    found : lines of files
    texts : more lines, with the names `text_1`, `text_2` and so on
    recordings : folder with one recording per line, which has the name of the line
    remark : receives the names of lines without a recording, which are left out

    Raises
    ------
    LipsyncError
        There are no lines or too many, or two lines have the same name.
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
    return tuple(lines) if recordings is None else _recorded(lines, recordings, remark)


def _recorded(
    lines: list[StudyLine], folder: Path, remark: Callable[[str], None]
) -> tuple[StudyLine, ...]:
    """Return the lines with a recording, and add it to each."""
    files = files_by_stem(folder)
    without = [line.name for line in lines if line.name not in files]
    if without:
        some = shortlist(without, MAX_LISTED_LINES)
        remark(f"{folder}: has no recordings with the names {some}; these lines are left out")
    found = [line for line in lines if line.name in files]
    if not found:
        raise LipsyncError(
            f"{folder}: has no recording with the name of a line; "
            "name each recording after its line"
        )
    return tuple(replace(line, recording=only_file(files[line.name])) for line in found)


def files_by_stem(folder: Path) -> dict[str, list[Path]]:
    """List the visible files of a folder by name without suffix, each list in order.

    Raises
    ------
    LipsyncError
        The folder is missing or cannot be listed.
    """
    try:
        files = sorted(path for path in folder.iterdir() if path.is_file())
    except OSError as error:
        raise LipsyncError(
            f"{folder}: cannot be listed: {error.strerror}; check the path"
        ) from None
    found: dict[str, list[Path]] = {}
    for path in files:
        if not path.name.startswith("."):
            found.setdefault(path.name.split(".")[0], []).append(path)
    return found


def only_file(files: list[Path]) -> Path:
    """Return the file of a line.

    Raises
    ------
    LipsyncError
        The line has several files.
    """
    if len(files) > 1:
        names = " and ".join(path.name for path in files[:2])
        raise LipsyncError(f"{files[0].parent}: has {names} for one line; keep one of them")
    return files[0]


def timed(line: StudyLine, performer: "Performer", *, engine: str | None = None) -> "Schedule":
    """Return the timed phonemes of a line, with its sound.

    Raises
    ------
    LipsyncError
        The text cannot be spoken, or the recording cannot be read or aligned.
    """
    if line.recording is None:
        return line.schedule or performer.speaker.speak(line.text, engine=engine)
    if line.schedule is not None:
        from lipsync_lang.speech.sound import with_sound

        return with_sound(line.schedule, line.recording)
    from lipsync_lang.speech.hearing.alignment import aligned

    return aligned(performer.speaker, line.recording, line.text)
