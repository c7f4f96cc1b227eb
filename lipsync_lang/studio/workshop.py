"""The workshop: an open language-character pair, and the line that it speaks.

The routes of the server call it; nothing here knows of the web. One workshop serves every tab of
one user, one call at a time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.finding import FOLDERS, POSESET
from lipsync_lang.packs.library import Library
from lipsync_lang.performing.performer import Performer
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.resolver.settings import motion_with
from lipsync_lang.rigs.container import Json

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.resolver.compiled import Compiled
    from lipsync_lang.schedules.schedule import Schedule

OWN = ("path", "project")
"""Origins of folders whose packs are the user's."""


@dataclass
class LineSettings:
    """LineSettings of the line; the fields are those of `Performer.perform`."""

    fps: float = 60.0
    line: str | None = None
    styles: dict[str, Any] = field(default_factory=dict)
    dials: dict[str, Any] = field(default_factory=dict)
    intensity: float | None = None

    def asked(self) -> Json:
        """Return the options of `Performer.perform` without the frame rate."""
        return {
            "line": self.line,
            "styles": self.styles or None,
            "dials": self.dials or None,
            "intensity": self.intensity,
        }


class Workshop:
    """An open pair and its line.

    Parameters
    ----------
    project : folder for new packs
    paths : folders and files searched first
    motion : changed settings of motion, or a preset
    engine : speech engine instead of the language's
    """

    def __init__(
        self,
        project: Path,
        paths: Sequence[Path] = (),
        *,
        motion: Mapping[str, object] | str | None = None,
        engine: str | None = None,
    ) -> None:
        self.project, self.paths = project, tuple(paths)
        self.motion, self.engine = motion, engine
        self.language = self.character = ""
        self.settings = LineSettings()
        self.schedule: Schedule | None = None
        self.text = ""
        self._now: Performer | None = None

    # Packs

    def library(self) -> Library:
        """Return the packs."""
        return Library(self.paths, self.project)

    def open(self, language: str, character: str) -> None:
        """Open a pair; the workshop stays as it was if it cannot be resolved."""
        before = self.language, self.character
        self.language, self.character = language, character
        self._now = None
        try:
            performer = self.performer
        except LipsyncError:
            self.language, self.character = before
            raise
        if performer.compiled.language != before[0]:
            self.schedule = None

    @property
    def performer(self) -> Performer:
        """Performer of the open pair."""
        if not self.language or not self.character:
            raise LipsyncError("no pair is open; choose a language and a character")
        if self._now is None:
            self._now = self._performer(self.library())
        return self._now

    def _performer(self, library: Library) -> Performer:
        compiled: Compiled = compile_pair(library, self.language, self.character)
        return Performer(compiled, motion_with(compiled.motion, self.motion), "rest", self.paths)

    def own(self, path: Path) -> bool:
        """Return True if a pack file is the user's, and so can be edited in place."""
        roots = [root.path for root in self.library().roots if root.origin in OWN]
        homes = [root / folder for root in roots for folder in FOLDERS.values()]
        return path in roots or any(path.is_relative_to(home) for home in homes)

    def editable(self, name: str) -> tuple[Path, str | None]:
        """Return the file that an edit of a pack goes to, and its first text if it is new.

        Parameters
        ----------
        name : an identifier of `files`

        Raises
        ------
        LipsyncError
            The pack is not the user's, and a pack of the project cannot add to it.
        """
        files, compiled = self.files(), self.performer.compiled
        path = files.get(name)
        if path is not None and self.own(path):
            return path, None
        if name == "language":
            own = self.project / FOLDERS["language"] / f"{compiled.language}.yaml"
            head = f"kind: language\nformat: 1\nname: {compiled.language}\n"
            return own, f"{head}extends: {compiled.language}\n"
        if name == "character":
            own = self.project / FOLDERS["character"] / f"{compiled.character}.yaml"
            head = f"kind: character\nformat: 1\nname: {compiled.character}\n"
            return own, f"{head}poseset: {compiled.poseset}\n"
        if path is None:
            raise LipsyncError(f"no pack '{name}' is open; it is one of {', '.join(files)}")
        raise LipsyncError(
            f"{self.shown(path)} belongs to the installed packs; copy it into the project first"
        )

    def files(self) -> dict[str, Path]:
        """Return the packs of the open pair by the identifiers that the browser names them by."""
        compiled, library = self.performer.compiled, self.library()
        found = {
            "language": library.find("language", compiled.language),
            "poseset": library.find("poseset", compiled.poseset),
        }
        own = library.finder.lookup("character", compiled.character)
        if own:
            found["character"] = Path(own[0])
        for number, path in enumerate(library.banks_of(compiled.poseset)):
            found[f"bank-{number}"] = path
        return found

    # The line

    def speak(self, text: str) -> None:
        """Speak a text; it becomes the line."""
        self.schedule = self.performer.speaker.speak(text, engine=self.engine)
        self.text = text

    def perform(self, performer: Performer | None = None) -> "Animation":
        """Perform the line, by another performer or that of the unsaved edits."""
        if self.schedule is None:
            raise LipsyncError("there is no line; type one, or open timed phonemes")
        one = performer or self.performer
        return one.perform(self.schedule, self.settings.fps, **self.settings.asked())

    # State

    def state(self) -> Json:
        """Return what every view needs to know, as JSON data."""
        told: Json = {"language": self.language, "character": self.character}
        if not self.language:
            return told
        performer = self.performer
        compiled = performer.compiled
        poseset = self.library().poseset(compiled.poseset).model
        return told | {
            "poseset": compiled.poseset,
            "poses": [
                {"name": name, "title": pose.title or "", "region": pose.region or ""}
                for name, pose in poseset.poses.items()
            ],
            "phonemes": list(compiled.phonemes),
            "shades": compiled.shades,
            "measures": compiled.measures,
            "regions": compiled.regions,
            "styles": [*compiled.style_names, *compiled.style_drafts],
            "warnings": list(compiled.report.warnings),
            "text": self.text,
            "line": self.schedule is not None,
        }

    def shown(self, path: Path) -> str:
        """Return a pack's file as the user knows it: relative to the project, or its last parts."""
        if path.is_relative_to(self.project):
            return path.relative_to(self.project).as_posix()
        parts = path.parts[-3 if path.name == POSESET else -2 :]
        return "/".join(parts)
