"""Methods of lip sync in a study, all on the same face, schedule and frames."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from lipsync_lang import Animation, LipsyncError, Performer, Schedule, TimedWords, read_timings
from lipsync_lang.animations.animation_readers import ANIMATION_READERS
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.base.files import read_input
from lipsync_lang.packs.library import Library
from lipsync_lang.plugins.study.study_lines import files_by_stem, only_file
from lipsync_lang.reports.quality.baselines import BASELINES
from lipsync_lang.reports.quality.fitting import on_model, read_for

OURS = "ours"
"""Method of the performer itself."""

PERFORMER_METHODS = ("character", "bank", "motion")
"""Prefixes of methods that change the performer."""

USUAL_MANNER = "keyframes"
"""Plain method for timings of other programs: one key per shape, as in most tables."""

MAX_APART_SECONDS = 0.5
"""Maximum difference between the ends of a line and of its curve file."""

MAX_METHOD_CHARS = 100

REST_FRAMES = 2
"""Minimum number of frames in which a mouth opens from rest at the start of a clip."""

MAX_BANK_BYTES = 64 * 2**20

CHECK_SHIFT_SECONDS = 0.4
"""Delay of the mouth in the wrong clip of an attention check."""


class Method(NamedTuple):
    """A named method, and the source of its curves."""

    name: str
    how: str
    """`ours`, a plain method, one of `PERFORMER_METHODS`, or `files`."""
    what: str = ""
    """The character, bank, preset or folder."""
    manner: str = USUAL_MANNER
    """Plain method for timings in the folder."""


def parse_method(text: str) -> Method:
    """Parse a method: a built-in name, or NAME=SOURCE.

    >>> parse_method("angry=motion:paper")
    Method(name='angry', how='motion', what='paper', manner='keyframes')

    Raises LipsyncError if the source is unknown, or its folder is missing.
    """
    built_in = (OURS, *BASELINES)
    name, equals, source = text.partition("=")
    source = source if equals else name
    if not name.strip() or len(name) > MAX_METHOD_CHARS or not name.isprintable():
        raise LipsyncError(f"method '{text}': write NAME=SOURCE with a short name")
    if source in built_in:
        return Method(name, source)
    how, colon, what = source.partition(":")
    if colon and how in PERFORMER_METHODS and what:
        return Method(name, how, what)
    # A folder may have a colon in its name, or a drive of Windows before it.
    manner, folder = (how, what) if colon and how in BASELINES else (USUAL_MANNER, source)
    if equals and Path(folder).is_dir():
        return Method(name, "files", folder, manner)
    known = f"{', '.join(built_in)}; or NAME=FOLDER with a file for each line, "
    known += ", ".join(f"NAME={one}:..." for one in PERFORMER_METHODS)
    hint = f"there is no folder '{folder}'" if equals else did_you_mean(source, built_in)
    raise LipsyncError(f"method '{text}': {hint}; give {known}")


def parse_methods(texts: list[str]) -> tuple[Method, ...]:
    """Parse two or more methods with different names, or raise a LipsyncError."""
    methods = tuple(map(parse_method, texts))
    names = [method.name for method in methods]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise LipsyncError(f"method '{twice}' is given twice; give each a name (NAME=SOURCE)")
    if len(methods) < 2:  # noqa: PLR2004 a pair
        known = f"`ours`, {', '.join(BASELINES)}, or NAME=SOURCE"
        raise LipsyncError(f"a study compares two methods or more; give {known}")
    return methods


@dataclass(frozen=True, eq=False)
class StudyCharacter:
    """A character that the methods animate."""

    performer: Performer
    """Performer of the character; all methods share its face and its frames."""
    model: Path
    """Model to draw."""
    other: Callable[[Method], Performer]
    """Resolves the performer of a method with its own performer."""
    fps: float = 30

    @property
    def name(self) -> str:
        """Name of the character."""
        return self.performer.character

    def frames(self, schedule: Schedule) -> Animation:
        """Return the character's own performance, whose face and frames all methods share."""
        return self.shown(self.performer.perform(schedule, self.fps))

    def animate(self, method: Method, line: str, own: Animation) -> Animation:
        """Animate a line by a method, over the frames of the character's own performance.

        Raises LipsyncError if the method has no curves for the line, or its curves are for another
        line or face. Files are found by the name of the line; `own` is the result of `frames`.
        """
        if method.how == OURS:
            return own
        if method.how in PERFORMER_METHODS:
            other = self.other(method)
            made = other.perform(own.schedule, self.fps)
            if made.poses != self.performer.poses:
                made = other.rigged(made)
                if {one.name for one in own.columns}.isdisjoint(one.name for one in made.columns):
                    what = f"{other.character} moves no pose or channel of {self.name}"
                    mend = "name a character with the same pose set or rig"
                    raise LipsyncError(f"method '{method.name}': {what}; {mend}")
            return _over(self.shown(made), own)
        if method.how in BASELINES:
            made = BASELINES[method.how](self.performer, own.schedule, self.fps)
        else:
            files = _listed(Path(method.what)).get(line)
            if not files:
                raise LipsyncError(f"{method.what}: has no file for line '{line}'")
            made = self._read(method, only_file(files), own.schedule)
        return _from_rest(_over(self.shown(made), own))

    def shown(self, animation: Animation) -> Animation:
        """Return an animation on the model to draw."""
        return replace(on_model(animation, self.performer), model=self.model, source=None)

    def _read(self, method: Method, path: Path, schedule: Schedule) -> Animation:
        """Read an animation, or timings that a plain method animates."""
        refused: LipsyncError | None = None
        if path.suffix.lower() in ANIMATION_READERS.suffixes():
            try:
                made, _ = read_for(self.performer, path, schedule)
            except LipsyncError as error:
                # The file may be timings in the same suffix; only if they fail too, the first error
                # is told.
                refused = error
            else:
                _refuse_apart(path, float(made.times[-1]), schedule)
                return made
        try:
            timings = read_timings(path)
        except LipsyncError as error:
            raise (refused or error) from None
        if isinstance(timings, TimedWords):
            raise LipsyncError(f"{path}: has only times of words; export phonemes or mouth shapes")
        _refuse_apart(path, timings.end, schedule)
        made = BASELINES[method.manner](self.performer, timings, self.fps)
        return replace(made, schedule=schedule)


def with_bank(
    performer: Performer, name: str, bank: Path, resolved: Callable[[Path], Performer]
) -> Performer:
    """Return the performer of a character with another bank, which precedes its own banks."""
    library = Library(performer.paths)
    character = library.character(name)
    plain = character.model.model_dump(mode="json", exclude_defaults=True)
    plain |= {"kind": "character", "format": 1, "poseset": character.model.poseset}
    banks = [bank, *(one.path for one in library.character_banks(character))]
    with TemporaryDirectory(prefix="lipsync-lang-") as folder:
        names = [f"{number}/{path.name}" for number, path in enumerate(banks)]
        for own_name, path in zip(names, banks, strict=True):
            # Packs may name only files below their folder, and banks come from anywhere.
            copied = Path(folder, own_name)
            copied.parent.mkdir()
            copied.write_bytes(read_input(path, MAX_BANK_BYTES, mend="name a bank"))
        plain |= {"name": "with_bank", "banks": names}
        # The model's path starts at the folder of the character, and a study draws its own.
        plain.pop("model", None)
        path = Path(folder, "with_bank.yaml")
        path.write_text(json.dumps(plain), "utf-8")
        return resolved(path)


@cache
def _listed(folder: Path) -> dict[str, list[Path]]:
    return files_by_stem(folder)


def lacks(method: Method, line: str) -> bool:
    """Return True if a method reads files and has none for a line."""
    return method.how == "files" and line not in _listed(Path(method.what))


def _refuse_apart(path: Path, end: float, schedule: Schedule) -> None:
    """Refuse curves that end long before or after the line."""
    if abs(end - schedule.end) > MAX_APART_SECONDS + 0.1 * schedule.end:
        what = f"ends at {end:.1f} s, but the line ends at {schedule.end:.1f} s"
        raise LipsyncError(f"{path}: {what}; check that the file is for this line")


def _over(made: Animation, own: Animation) -> Animation:
    """Return an animation over the frames of another, and hold its first and last frames."""
    if np.array_equal(made.times, own.times):
        return made
    columns = [np.interp(own.times, made.times, column) for column in made.weights.T]
    weights = np.column_stack(columns)
    return replace(made, times=own.times, weights=weights, fps=own.fps, schedule=own.schedule)


def _from_rest(animation: Animation) -> Animation:
    """Return an animation that starts from rest before the line, and returns to rest after it.

    An open mouth in the first picture would reveal the method, and change the light of the model.
    """
    times, step = animation.times, REST_FRAMES / animation.fps
    begin = max(0.0, times[0] + step)
    end = min(animation.schedule.end, times[-1] - step)
    rising = (times - times[0]) / (begin - times[0])
    sinking = (times[-1] - times) / (times[-1] - end)
    share = np.clip(np.minimum(rising, sinking), 0.0, 1.0)
    return replace(animation, weights=animation.weights * share[:, None])


def spoilt(own: Animation, number: int) -> Animation:
    """Return a deliberately wrong animation for an attention check: late and still in turn."""
    if number % 2:
        return replace(own, weights=np.zeros_like(own.weights))
    late = own.times - CHECK_SHIFT_SECONDS
    columns = [np.interp(late, own.times, column) for column in own.weights.T]
    return replace(own, weights=np.column_stack(columns))
