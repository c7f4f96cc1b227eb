"""Workshop: an open language-character pair with its unsaved edits, and its line.

The routes of the server call it; this module does not depend on the web. A workshop serves all tabs
of one user, one call at a time.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.animations.animation import Animation
from lipsync_lang.errors import LipsyncError
from lipsync_lang.files.reach import refuse_outside
from lipsync_lang.json_object import Json
from lipsync_lang.lines.markup import AS_WRITTEN, Cleaning
from lipsync_lang.packs.finding import FOLDERS, POSESET
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.splicing import SplicedText
from lipsync_lang.performing.performer import Performer
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.resolver.retouch import OpenPair
from lipsync_lang.resolver.settings import motion_with
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.studio.bigram_home import bigram_home
from lipsync_lang.studio.desk import Desk
from lipsync_lang.studio.edited_pair import EditedPair
from lipsync_lang.studio.merging import Choices
from lipsync_lang.studio.project_lines import ProjectLines
from lipsync_lang.studio.sheets import PackEdit
from lipsync_lang.studio.spoken_line import MAX_PART_FRAMES, SpokenLine

if TYPE_CHECKING:
    from lipsync_lang.build.planned_line import PlannedLine

OWN = ("path", "project")
"""Origins of folders with the user's packs."""


@dataclass
class LineSettings:
    """Settings of the performed line; the fields are those of `Performer.perform`."""

    fps: float = 60.0
    line: str | None = None
    styles: dict[str, Any] = field(default_factory=dict)
    dials: dict[str, Any] = field(default_factory=dict)
    intensity: float | None = None


class Workshop:
    """An open pair and its line.

    `project` is the folder for new packs, and `paths` are searched first. `motion` are changed
    settings of motion, or a preset, and `engine` replaces the speech engine of the language.
    """

    def __init__(  # noqa: PLR0913 a folder, packs, and settings of lines
        self,
        project: Path,
        paths: Sequence[Path] = (),
        desk: Desk | None = None,
        *,
        motion: Mapping[str, object] | str | None = None,
        engine: str | None = None,
        cleaning: Cleaning = AS_WRITTEN,
        script: ProjectLines | None = None,
    ) -> None:
        self.project, self.paths = project.absolute(), tuple(paths)
        self.desk = Desk(None) if desk is None else desk
        self.motion, self.engine, self.cleaning = motion, engine, cleaning
        self.language = self.character = ""
        self.settings = LineSettings()
        self.line: SpokenLine | None = None
        self.text = ""
        self.script = ProjectLines() if script is None else script
        self.script_line: PlannedLine | None = None
        """The line of the script that is open."""
        self._corrected: dict[PlannedLine, SpokenLine] = {}
        """Lines of the script that were corrected by hand."""
        self._library: tuple[int, Library] | None = None
        self._pair: EditedPair | None = None
        self.homes: dict[str, Path] = {}
        """Cached target files for edits of bigrams."""
        self._now: tuple[int, Performer] | None = None
        self._saved: Performer | None = None

    def library(self) -> Library:
        """Return the packs with the unsaved edits; packs without edits are not read again.

        The disk is read again whenever a pair is opened.
        """
        revision = self.desk.revision
        if self._library is None or self._library[0] != revision:
            made = Library(
                self.paths, self.project, unsaved=self.desk.contents, earlier=self._earlier()
            )
            self._library = revision, made
        return self._library[1]

    def open(self, language: str, character: str) -> None:
        """Open a pair; the workshop stays unchanged if the pair cannot be resolved."""
        before = self.language, self.character
        self.language, self.character = language, character
        self.look_again()
        try:
            performer = self.performer
        except LipsyncError:
            self.language, self.character = before
            raise
        if performer.compiled.language != before[0]:
            self._keep_corrections()
            self.line = self.script_line = None
        if (self.language, self.character) != before:  # styles and regions are a character's own
            self.settings = LineSettings(fps=self.settings.fps)

    def open_restored(self, language: str, character: str) -> None:
        """Open a pair after a start, and undo restored edits that no longer fit.

        They can be redone; `Desk.notes` says so.
        """
        first = ""
        for undone in count():
            try:
                self.open(language, character)
            except LipsyncError as error:
                if self.desk.undo_title is None:
                    raise
                first = first or str(error)
                self.desk.undo()
                continue
            if undone:
                self.desk.notes.append(
                    f"{undone} restored steps were undone (redo brings them back), because "
                    f"{language} cannot be performed on {character} with them: {first}"
                )
            return

    @property
    def performer(self) -> Performer:
        """Performer of the open pair with the unsaved edits."""
        if not self.language or not self.character:
            raise LipsyncError("no pair is open; choose a language and a character")
        revision = self.desk.revision
        if self._now is None or self._now[0] != revision:
            if self.desk.contents or self._pair is not None or self.project != Path.cwd():
                performer = self._performer(self.pair().compiled)
            else:  # the cache of the command line has it, perhaps
                found = resolve(
                    self.language, self.character, paths=self.paths, gaps="rest", unknown="rest",
                    motion=self.motion,
                )  # fmt: skip
                performer = replace(found, cleaning=self.cleaning)
            self._now = revision, performer
        return self._now[1]

    def pair(self) -> OpenPair:
        """Return the open pair with its packs and the unsaved edits."""
        if self._pair is None or self._pair.revision != self.desk.revision:
            known = None if self._pair is None else self._pair.current(self.desk)
            self._pair = known or EditedPair.of(self._open(self.desk.contents), self.desk)
        return self._pair.pair

    def _open(self, contents: Mapping[Path, bytes]) -> OpenPair:
        library = Library(self.paths, self.project, unsaved=contents, earlier=self._earlier())
        return OpenPair.open(library, self.language, self.character)

    def _earlier(self) -> Library | None:
        """Return the library with the most packs in memory: that of the open pair."""
        if self._pair is not None:
            return self._pair.pair.shelf.library
        return None if self._library is None else self._library[1]

    def look_again(self) -> None:
        """Forget all packs that were read, since the disk may have changed."""
        self.homes.clear()
        self._library = self._now = self._saved = self._pair = None

    @property
    def saved(self) -> Performer:
        """Performer of the open pair as last opened or saved."""
        if not self.desk.contents:
            return self.performer
        if self._saved is None:
            library = Library(self.paths, self.project, earlier=self._earlier())
            compiled = compile_pair(library, self.language, self.character)
            self._saved = self._performer(compiled)
        return self._saved

    def save(self, keep: Choices | None = None) -> list[Path]:
        """Save every edit, and return the files written; see `Desk.save`."""
        before = self.desk.contents
        written = self.desk.save(keep=keep)
        self._saved = None
        if any(self.desk.content(path) != content for path, content in before.items()):
            self.look_again()  # the disk had changed as well
        return written

    def _performer(self, compiled: CompiledPair) -> Performer:
        motion = motion_with(compiled.motion, self.motion)
        return Performer(compiled, motion, "rest", self.paths, cleaning=self.cleaning)

    def edit(self, title: str, edits: Sequence[PackEdit], **more: Any) -> None:
        """Change packs as `Desk.change` does; refuse an edit that makes the pair unperformable."""
        for path in {path for path, _, _ in edits}:
            self.refuse_link(path)
        # The pair is compiled with the edits before the desk takes them, and kept if it does.
        rehearsed: list[OpenPair] = []
        if any(self.homes.get(str(loc[1]) if loc[1:] else "") != path for path, loc, _ in edits):
            self.homes.clear()

        def rehearse(texts: Mapping[Path, SplicedText]) -> None:
            contents = {path: text.content for path, text in texts.items()}
            contents = {**self.desk.contents, **contents}
            self.pair()  # so that there is one to change
            pair = None if self._pair is None else self._pair.changed(contents, texts)
            rehearsed.append(pair or self._open(contents))

        self.desk.change(title, edits, check=rehearse if self.language else None, **more)
        for pair in rehearsed:
            self._pair = EditedPair.of(pair, self.desk)

    def refuse_link(self, path: Path) -> None:
        """Refuse to write a file of the project that is a link out of it."""
        if path.is_relative_to(self.project):
            refuse_outside(path, self.project)

    def own(self, path: Path) -> bool:
        """Return True if a pack file belongs to the user and can be edited in place."""
        roots = [root.path for root in self.library().roots if root.origin in OWN]
        homes = [root / folder for root in roots for folder in FOLDERS.values()]
        return path in roots or any(path.is_relative_to(home) for home in homes)

    def editable(self, name: str) -> tuple[Path, str | None]:
        """Return the target file for an edit of a pack, and its initial text if it is new.

        `name` is an identifier of `files`. Raises LipsyncError if the pack does not belong to the
        user, and a pack of the project cannot extend it.
        """
        files, compiled = self.files(), self.performer.compiled
        path = files.get(name)
        if path is not None and self.own(path):
            return path, None
        if name == "language" and path is None:
            raise LipsyncError(
                f"{compiled.language} has no pack to edit; create {FOLDERS['language']}/NAME.yaml "
                f"with `extends: {compiled.language}`, and open NAME"
            )
        if name == "language":
            own = self.project / FOLDERS["language"] / f"{compiled.language}.yaml"
            tag = self.library().language(compiled.language).model.tag
            head = f"kind: language\nformat: 1\nname: {compiled.language}\ntag: {tag}\n"
            return own, f"{head}extends: {compiled.language}\n"
        if name == "character":
            own = self.project / FOLDERS["character"] / f"{compiled.character}.yaml"
            head = f"kind: character\nformat: 1\nname: {compiled.character}\n"
            return own, f"{head}poseset: {compiled.poseset}\n"
        if path is None:
            raise LipsyncError(f"no pack '{name}' is open; the open packs are {', '.join(files)}")
        raise LipsyncError(
            f"{self.shown(path)} belongs to the installed packs; copy it into the project first"
        )

    def bank_for(self, pair: str) -> tuple[Path, str | None]:
        """Return the target file for an edit of a bigram, and its initial text if it is new.

        The file is cached, since the search for it reads banks, and edits do not change it.
        """
        from lipsync_lang.banks.write import empty_bank

        if pair not in self.homes:
            first, _, second = pair.partition("-")
            path, _ = bigram_home(self.pair().shelf, (first, second), self.project, self.own)
            self.homes[pair] = path
        path = self.homes[pair]
        known = path.exists() or path in self.desk.contents
        return path, None if known else empty_bank(self.performer.compiled.poseset, path)

    def files(self) -> dict[str, Path]:
        """Return the packs of the open pair by their identifiers in the browser."""
        compiled, library = self.performer.compiled, self.library()
        found = {"poseset": library.find("poseset", compiled.poseset)}
        language = library.lookup("language", compiled.language)
        if language:  # one that an engine reads alone has no file
            found["language"] = Path(language[0])
        own = library.lookup("character", compiled.character)
        if own:
            found["character"] = Path(own[0])
        for number, path in enumerate(library.banks_of(compiled.poseset)):
            found[f"bank-{number}"] = path
        return found

    @property
    def part_seconds(self) -> float:
        """Maximum length of the shown part of a line, in seconds."""
        return MAX_PART_FRAMES / max(self.settings.fps, 1.0)

    @property
    def schedule(self) -> Schedule | None:
        """The line, or the shown part of a long line."""
        return None if self.line is None else self.line.part(self.part_seconds)

    def speak(self, text: str) -> None:
        """Speak a text as the line."""
        self.take_up(self.performer.speaker.speak(text, engine=self.engine), text)

    def take_up(self, schedule: Schedule, text: str) -> None:
        """Open a line, and drop levels over the time of the line before it."""
        self._keep_corrections()
        self.line, self.text, self.script_line = SpokenLine(schedule), text, None
        styles, dials = (
            {name: level for name, level in levels.items() if not isinstance(level, list)}
            for levels in (self.settings.styles, self.settings.dials)
        )
        self.settings = replace(self.settings, styles=styles, dials=dials)

    def _keep_corrections(self) -> None:
        """Keep the open line of the script if it was corrected."""
        if self.line is not None and self.script_line is not None and self.line.corrected:
            self._corrected[self.script_line] = self.line

    def open_script_line(self, name: str) -> None:
        """Time a line of the script in the open language; it becomes the line.

        Edits that the character has for a line of this name are performed, as in a build. A line
        that was corrected by hand is as it was left, unless its text or its files are others now.
        """
        performer = self.performer
        line = self.script.line(performer.compiled.language, name, performer.compiled.character)
        self._keep_corrections()
        corrected = self._corrected.get(line)
        schedule = (
            self.script.schedule(line, performer.speaker, self.engine)
            if corrected is None
            else corrected.whole
        )
        performer.common_phonemes(schedule)  # refuses labels of no notation
        self.take_up(schedule, line.text or " ".join(word.text for word in schedule.words))
        self.line, self.script_line = corrected or self.line, line
        self.settings.line = name if name in performer.compiled.line_edits else None

    def opened_pair(self) -> tuple[str, str]:
        """Return the names of the open language and character; empty if none is open."""
        if not self.language:
            return "", ""
        compiled = self.performer.compiled
        return compiled.language, compiled.character

    @property
    def spoken(self) -> SpokenLine:
        """The line; raises LipsyncError if there is none."""
        if self.line is None:
            raise LipsyncError("there is no line; type one, or open timed phonemes")
        return self.line

    def perform(self, performer: Performer | None = None) -> Animation:
        """Perform the line with another performer or the open one."""
        schedule, settings = self.spoken.part(self.part_seconds), self.settings
        loud = None if schedule.audio is None else settings.intensity
        return (performer or self.performer).perform(
            schedule, settings.fps, line=settings.line, styles=settings.styles or None,
            dials=settings.dials or None, intensity=loud,
        )  # fmt: skip

    def state(self) -> Json:
        """Return the state for all views as JSON data."""
        desk = self.desk
        data: Json = {
            "revision": desk.revision,
            "language": self.language,
            "character": self.character,
            "unsaved": list(self._unsaved()),
            "undo": desk.undo_title,
            "redo": desk.redo_title,
            "restored": desk.restored,
            "notes": desk.notes,
        }
        if not self.language:
            return data
        performer = self.performer
        compiled = performer.compiled
        poseset = self.library().poseset(compiled.poseset).model
        return data | {
            "poseset": compiled.poseset,
            "poses": [
                {"name": name, "title": pose.title or "", "region": pose.region or ""}
                for name, pose in poseset.poses.items()
            ],
            "phonemes": list(compiled.phonemes),
            "shades": compiled.shades,
            "measures": compiled.measures,
            "regions": compiled.regions,
            "styles": list(dict.fromkeys((*compiled.style_names, *compiled.style_drafts))),
            "lines": list(compiled.line_edits),
            "warnings": list(compiled.report.warnings),
            "text": self.text,
            "settings": asdict(self.settings),
            "line": self.line is not None,
        }

    def _unsaved(self) -> Iterator[Json]:
        """Yield every unsaved entry, except the heads of new files."""
        rows = self.desk.unsaved()
        new = {path for path, loc, what in rows if (loc, what) == (("kind",), "added")}
        for path, loc, what in rows:
            if path not in new or len(loc) > 1:
                yield {"file": self.shown(path), "at": list(loc), "what": what}
        for path in new - {path for path, loc, _ in rows if len(loc) > 1}:
            yield {"file": self.shown(path), "at": [], "what": "added"}

    def shown(self, path: Path) -> str:
        """Return the path of a pack for the user: relative to the project, or its last parts."""
        if path.is_relative_to(self.project):
            return path.relative_to(self.project).as_posix()
        parts = path.parts[-3 if path.name == POSESET else -2 :]
        return "/".join(parts)
