"""Input formats of timings, and the recognition of a file's format.

A file's content tells its format, before its suffix does: many programs write `.json`, `.lab`,
`.csv` and `.txt`.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.base.extensions import PROGRAM, Format, Formats
from lipsync_lang.base.files import argument_path
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timed_words import TimedWords
from lipsync_lang.schedules.timing_file import TimingFile

_log = logging.getLogger(__name__)

Timings = Schedule | TimedWords
"""Timings of a file: of its phonemes, or of its words alone."""

Read = Callable[[TimingFile], Timings]
Sniff = Callable[[TimingFile], bool]


@dataclass(frozen=True)
class ScheduleReader(Format):
    """An input format: its signature and its reader."""

    sniff: Sniff
    read: Read
    tiers: bool = False
    """True if a file may hold several tiers; `tier` names one."""

    script: bool = False
    """True if a file is a script as well, of which each cue is a line."""


TIMING_READERS: Formats[ScheduleReader] = Formats(
    "readers", "format", package="lipsync_lang.schedules.readers"
)


def reader(
    name: str, *suffixes: str, sniff: Sniff, tiers: bool = False, script: bool = False
) -> Callable[[Read], Read]:
    """Register a function ``(source) -> Schedule`` as the reader of a format.

    A reader of words without phonemes returns `TimedWords` (`timed_words.timed_words_of`).

    `sniff` tells by its content whether a file is in it: quickly, by ``source.head`` or
    ``source.document``, and without raising. Only with `tiers` may one be asked for.
    A `script` is counted line by line where scripts are, instead of as one line.
    """
    return TIMING_READERS.adding(
        lambda title, read: ScheduleReader(name, suffixes, title, sniff, read, tiers, script)
    )


def read_schedule(  # noqa: PLR0913 facts that a file may lack
    path: str | Path,
    notation: str | None = None,
    *,
    read_as: str | None = None,
    tier: str | None = None,
    rate: float | None = None,
    encoding: str | None = None,
) -> Schedule:
    """Read timed phonemes from a file.

    Raises ScheduleError if the file is missing, too large, of no known format, or its timings are
    unsound; or it times words alone (`read_timings` reads those).

    Parameters
    ----------
    path : the file; its content and its suffix tell the format. ``-`` is standard input
    notation : the labels' notation (`arpabet`, `ipa`, ...); None for what the format says, or
        else what the language pack can tell
    read_as : the name of the format, where neither content nor suffix tells
    tier : the tier, speaker or channel, where a file has several
    rate : units per second of the file's times; None for what the format says
    encoding : of the file's text; None for UTF-8 or UTF-16

    Examples
    --------
    >>> from pathlib import Path
    >>> Path("line.json").write_text('[{"label": "M", "start": 0, "end": 0.2}]') > 0
    True
    >>> ll.read_schedule("line.json", "arpabet").labels
    ('M',)
    """
    found = read_timings(path, notation, read_as=read_as, tier=tier, rate=rate, encoding=encoding)
    if isinstance(found, TimedWords):
        what = f"{found.source}: has timed words only, and their phonemes depend on the language"
        raise ScheduleError(f"{what}; add them with `fill_words(read_timings(PATH), LANGUAGE)`")
    return found


def read_timings(  # noqa: PLR0913 facts that a file may lack
    path: str | Path,
    notation: str | None = None,
    *,
    read_as: str | None = None,
    tier: str | None = None,
    rate: float | None = None,
    encoding: str | None = None,
) -> Timings:
    r"""Read timed phonemes from a file, or timed words if it has no phonemes.

    `TimedWords` are for `fill_words`. Parameters and errors are those of `read_schedule`.

    Examples
    --------
    >>> from pathlib import Path
    >>> Path("words.csv").write_text("word,start,end\nmaps,0.1,0.6\n") > 0
    True
    >>> ll.read_timings("words.csv").words[0].text
    'maps'
    """
    path = argument_path(path)
    if rate is not None and not 0 < rate < float("inf"):
        raise ScheduleError(f"{rate:g} units per second: give a number above 0")
    source = TimingFile.of(path, tier=tier, rate=rate, encoding=encoding)
    found = timings_of(source, read_as)
    if notation is None or isinstance(found, TimedWords):
        return found
    return replace(found, notation=notation)


def timings_of(source: TimingFile, read_as: str | None = None) -> Timings:
    """Read timings from the content of a file; see `read_timings`."""
    found = find_reader(source, read_as)
    _log.info("%s is read as %s", source.path, found.name)
    if source.tier is not None and not found.tiers:
        raise source.fault(f"{found.name} files have no tiers; leave out `tier={source.tier!r}`")
    return found.read(source)


def find_reader(source: TimingFile, name: str | None = None) -> ScheduleReader:
    """Return the reader of a file: the named one, or the one for its content and suffix."""
    if name is not None:
        return TIMING_READERS.find(name, ScheduleError)
    # Nobody else writes what our own readers know, such as our JSON: no others are imported.
    leading = TIMING_READERS.named(source.path)
    if leading is not None and leading.sniff(source):
        return leading
    named = TIMING_READERS.ending(source.path)
    own = [one for one in named if TIMING_READERS.origins[one.name] == PROGRAM]
    # A plug-in reads what no built-in reader knows; another suffix counts where its own does not.
    for readers in (lambda: own, lambda: TIMING_READERS.built_in().values(), TIMING_READERS.values):
        found = sorted((one for one in readers() if one.sniff(source)), key=attrgetter("name"))
        found = [one for one in found if one in named] or found
        if len(found) > 1:
            names = " or ".join(one.name for one in found)
            raise source.fault(f"may be {names}; choose one (`read_as={found[0].name!r}`)")
        if found:
            return found[0]
    if len(named) == 1:
        return named[0]
    # Damaged JSON and XML have no format because they cannot be parsed: say where the damage is.
    start = source.text.lstrip()[:1]
    if start in ("{", "["):
        _ = source.json
    elif start == "<":
        _ = source.xml
    if named:
        file = source.path.name.lower()
        every = (one for _, one in sorted(TIMING_READERS.items()))  # those of plug-ins, too
        fitting = [one for one in every if file.endswith(one.suffixes)]
        titles = "".join(f"\n  {one.name}: {one.title}" for one in fitting)
        raise source.fault(f"has none of the formats that end in '{source.path.suffix}':{titles}")
    known = ", ".join(TIMING_READERS.suffixes())
    raise source.fault(f"no reader for this suffix; known: {known} (`lipsync-lang formats`)")
