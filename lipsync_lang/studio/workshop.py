"""Workshop: an open language-character pair with its unsaved edits, and its line.

The routes of the server call it; this module does not depend on the web. A workshop serves all tabs
of one user, one call at a time.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import asdict, replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.banks.write import empty_bank
from lipsync_lang.packs.finding import FOLDERS, POSESET, Kind
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import SpokenEdits
from lipsync_lang.packs.splicing import ABSENT, SplicedText
from lipsync_lang.performing.delivery import corrected
from lipsync_lang.performing.gesturing import ALL
from lipsync_lang.performing.performer import Performer
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.resolver.retouch import OpenPair
from lipsync_lang.resolver.settings import motion_with
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.studio.bigram_home import bigram_home, known_style
from lipsync_lang.studio.desk import Desk, EditedPair, PackEdit
from lipsync_lang.studio.line_settings import LineSettings, brief
from lipsync_lang.studio.merging import Choices
from lipsync_lang.studio.project_lines import ProjectLines
from lipsync_lang.studio.spoken_line import MAX_PART_FRAMES, SpokenLine
from lipsync_lang.text.lines.cleaning import AS_WRITTEN, Cleaning
from lipsync_lang.text.phonology.emphasis import as_marked

if TYPE_CHECKING:
    from lipsync_lang.packs.yaml.source import Loc
    from lipsync_lang.production.builds.planned_line import PlannedLine

NAME_WORDS = 4
"""Number of words of a text that name its line."""

LEAST_MOVE = 1e-5
"""Seconds by which a moved boundary differs."""

CHANGES = ("styles", "dials", "bends", "intensity", "emphasis", "phonemes", "times", "placed")
"""Fields of a line that a person changes; the others say which line it is."""

OWN = ("path", "project")
"""Origins of folders with the user's packs."""


class Workshop:
    """An open pair and its line.

    `project` is the folder for new packs, and `paths` are searched first. `motion` are changed
    settings of motion, or a preset, and `engine` replaces the speech engine of the language. A line
    is shown with `gestures`.
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
        gestures: str = ALL,
        script: ProjectLines | None = None,
    ) -> None:
        self.project, self.paths = project.absolute(), tuple(paths)
        self.desk = Desk(None) if desk is None else desk
        self.motion, self.engine, self.cleaning = motion, engine, cleaning
        self.gestures = gestures
        self.language = self.character = ""
        self.settings = LineSettings()
        self.line: SpokenLine | None = None
        self.text = self.plain_text = ""
        """The text of the line, with and without marks that the character states."""
        self._aligned: dict[str, Schedule] = {}
        """Schedules of the open line by its text with marks."""
        self.script = ProjectLines() if script is None else script
        self.script_line: PlannedLine | None = None
        """The line of the script that is open."""
        self.name = "line"
        """Name of the open line, under which the character keeps it."""
        self.opened = 0
        """Number of lines opened so far."""
        self._stated: dict[str, dict[str, Any]] = {}
        """Statements of the character for each line."""
        self._followed = -1
        self._library: tuple[int, Library] | None = None
        self._pair: EditedPair | None = None
        self.homes: dict[str, Path] = {}
        """Cached target files for edits of bigrams."""
        self._now: tuple[int, Performer] | None = None
        self._saved: Performer | None = None
        self.others: dict[str, tuple[str, int, Performer]] = {}  # by `other_performer`

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
            self.line = self.script_line = None
        if (self.language, self.character) != before:  # styles and regions are a character's own
            self.settings = LineSettings(fps=self.settings.fps)
            self._rename()

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
                performer = self.performer_for(self.pair().compiled)
            else:  # the cache of the command line has it, perhaps
                found = resolve(
                    self.language, self.character, paths=self.paths, gaps="rest", unknown="rest",
                    motion=self.motion,
                )  # fmt: skip
                performer = replace(found, cleaning=self.cleaning)
            # The open line's settings are in seconds here, and may be in the middle of a change.
            self._stated = performer.compiled.line_deliveries
            self._now = revision, without_lines(performer)
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
        self.others = {}

    @property
    def saved(self) -> Performer:
        """Performer of the open pair as last opened or saved."""
        if not self.desk.contents:
            return self.performer
        if self._saved is None:
            library = Library(self.paths, self.project, earlier=self._earlier())
            compiled = compile_pair(library, self.language, self.character)
            self._saved = without_lines(self.performer_for(compiled))
        return self._saved

    def save(self, keep: Choices | None = None) -> list[Path]:
        """Save every edit, and return the files written; see `Desk.save`."""
        revision = self.desk.revision
        written = self.desk.save(keep)
        self._saved = None
        if self.desk.revision != revision:
            self.look_again()  # the disk had changed as well
        return written

    def performer_for(self, compiled: CompiledPair) -> Performer:
        """Return the performer of a compiled pair with the settings of the studio."""
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
            contents = {**self.desk.contents, **{at: text.content for at, text in texts.items()}}
            self.pair()  # so that there is one to change
            pair = None if self._pair is None else self._pair.changed(contents, texts)
            rehearsed.append(pair or self._open(contents))

        self.desk.change(title, edits, check=rehearse if self.language else bool, **more)
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

    def bank_for(self, pair: str, style: str = "") -> tuple[Path, str | None]:
        """Return the target file for an edit of a bigram, and its initial text if it is new.

        `style` names the style of the bank; neutral if it is empty. The file is cached, since the
        search for it reads banks, and edits do not change it.
        """
        key = f"{pair}:{style}" if style else pair
        if key not in self.homes:
            first, _, second = pair.partition("-")
            manner = known_style(self.performer.compiled, style)
            self.homes[key], _ = bigram_home(
                self.pair().shelf, (first, second), self.project, self.own, manner
            )
        path = self.homes[key]
        # A new bank may exist as an unsaved text alone.
        known = path.exists() or path in self.desk.contents
        return path, None if known else empty_bank(self.performer.compiled.poseset, path, style)

    def files(self) -> dict[str, Path]:
        """Return the packs of the open pair by their identifiers in the browser."""
        compiled, library = self.performer.compiled, self.library()
        found = {"poseset": library.find("poseset", compiled.poseset)}
        # A language that an engine reads alone has no file.
        named: dict[Kind, str] = {"language": compiled.language, "character": compiled.character}
        for kind, name in named.items():
            if own := library.lookup(kind, name):
                found[kind] = Path(own[0])
        banks = enumerate(library.banks_of(compiled.poseset))
        return found | {f"bank-{number}": path for number, path in banks}

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
        """Open a line as the character keeps it; nothing of the line before stays."""
        self.line, self.text, self.script_line = SpokenLine(schedule), text, None
        self.plain_text, self._aligned = text, {text: schedule}
        self.opened += 1
        self._rename()

    def _rename(self) -> None:
        """Name the open line: as in the script, or by its first words."""
        if self.line is None:
            return
        if self.script_line is not None:
            self.name = self.script_line.name
        else:
            self.performer  # noqa: B018 reads what the character states
            stem = "-".join(re.findall(r"\w+", self.text.casefold())[:NAME_WORDS]) or "line"
            # A character may keep another text with the same first words.
            names = chain([stem], (f"{stem}-{number}" for number in count(2)))
            self.name = next(
                name for name in names
                if self._stated.get(name, {}).get("text", self.text) == self.text
                and not self.script.has(name)
            )  # fmt: skip
        self.follow()

    def follow(self) -> None:
        """Apply the packs, with their unsaved edits, to the open line."""
        if self.line is None or not self.language:
            return
        compiled = self.performer.compiled
        self._followed = self.desk.revision
        stated = self._stated.get(self.name, {})
        text = as_marked(self.plain_text, stated.get("text"))
        if text != self.text and self.line.opened.confidence is not None:
            with suppress(LipsyncError):  # as it is, the line can be performed
                self._align(text)
        whole = corrected(stated, compiled, self.line.opened, self.name)
        used = whole.labels != self.line.opened.labels
        self.line.changes = stated.get("phonemes", ()) if used else ()
        self.line.retime(whole)
        known = self.name if self.name in compiled.line_edits else None
        self.settings = LineSettings.of(stated, whole, self.settings.fps, known)

    def say(self, number: int) -> None:
        """Mark a word that the aligner left out as spoken, and align the line again."""
        before = self.spoken
        self._align(before.text_with(number, self.text))
        self.spoken.emphasise_as(before.whole)

    def _align(self, text: str) -> None:
        """Align the line with a text of other marks, unless its times are known."""
        from lipsync_lang.sound.speech.hearing.alignment import aligned

        at, audio, known = self.spoken.at, self.spoken.opened.audio, self._aligned
        if text not in known and audio is not None:
            known[text] = aligned(self.performer.speaker, audio, text)
        self.line, self.text = SpokenLine(replace(known[text], audio=audio)), text
        self.line.at = at

    def keep(self, title: str, tab: str = "", merge: str = "") -> None:
        """Make the changes of the open line one step, which undo reverts and saving writes."""
        if self.line is None:
            return
        language = self.performer.compiled.language
        before = self._stated.get(self.name)
        foreign = self._foreign(before or {}, language)
        old = {
            key: value if key == "bends" else brief(value)
            for key, value in (before or {}).items()
            if value and not (foreign and key in SpokenEdits.model_fields)
        }
        now = self._statement(language).items()
        new = {key: one for key, one in now if old.get(key, ABSENT) != one}
        if new.keys().isdisjoint(CHANGES) and old.get("text", self.plain_text) == self.text:
            return
        path, text = self.editable("character")
        at: Loc = ("lines", self.name)
        edits: list[PackEdit] = [(path, at, new)]
        if before is not None:
            place = (*at, "languages", language) if foreign or "further" in before else at
            own = dict.fromkeys(SpokenEdits.model_fields, place)
            edits = [
                (path, (*own.get(key, at), key), one)
                for key, one in new.items()
                if key != "language" or place is at
            ]
        if text is not None:
            # One step with the new file, so that undo removes it as well.
            edits.insert(0, (path, (), text))
        title = f"{title} ({self.name})"  # undo can revert it while another line is open
        self.edit(title, edits, tab=tab, merge=merge and f"{self.name} {merge}")
        self.follow()

    def _foreign(self, stated: Mapping[str, Any], language: str) -> bool:
        """Return True if a statement is of the line in another language."""
        text = stated.get("text", self.plain_text)
        if "language" in stated or self.script_line is None:
            return bool(stated.get("language", language) != language)
        return as_marked(self.plain_text, text) != text

    def _statement(self, language: str) -> dict[str, Any]:
        """Return what a character's file states for the open line; `ABSENT` for nothing."""
        line = self.spoken
        whole, opened = line.whole, line.unmoved
        emphasis = [
            [number, new.emphasis]
            for number, (new, old) in enumerate(zip(whole.words, opened.words, strict=True))
            if new.emphasis != old.emphasis
        ]
        moved = np.abs(whole.times - opened.times) > LEAST_MOVE
        times = [
            [int(at), round(float(opened.times[at]), 5), round(float(whole.times[at]), 5)]
            for at in moved.nonzero()[0]
        ]
        found = {
            "language": language,
            "text": None if self.script_line and self.text == self.plain_text else self.text,
            **self.settings.stated(whole),
            "emphasis": emphasis,
            "phonemes": [[first, list(was), list(now)] for first, was, now in line.changes],
            "times": times,
        }
        return {key: ABSENT if one in (None, "", [], {}) else one for key, one in found.items()}

    def open_script_line(self, name: str) -> None:
        """Time a line of the script in the open language; it becomes the line.

        What the character states for a line of this name is performed, as in a build.
        """
        performer = self.performer
        line = self.script.line(performer.compiled.language, name, performer.compiled.character)
        text = as_marked(line.text, self._stated.get(line.name, {}).get("text"))
        schedule = self.script.schedule(replace(line, text=text), performer, self.engine)
        performer.common_phonemes(schedule)  # refuses labels of no notation
        self.take_up(schedule, text or " ".join(word.text for word in schedule.words))
        self.plain_text, self.script_line = line.text or self.text, line
        self._rename()

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

    def perform(
        self,
        performer: Performer | None = None,
        schedule: Schedule | None = None,
        gestures: str | None = None,
    ) -> Animation:
        """Perform the shown part of the line, or another schedule of it, with any performer."""
        line, settings = self.spoken, self.settings
        schedule = schedule or line.part(self.part_seconds)
        loud = None if schedule.audio is None else settings.intensity
        performer = performer or self.performer
        return performer.perform(
            schedule, settings.fps, line=settings.line, styles=settings.styles or None,
            dials=settings.dials or None, intensity=loud, bends=settings.bends or None,
            gestures=gestures if performer.gesture_set.poses else None, placed=settings.placed,
            whole=None if schedule is line.whole else line.whole,
        )  # fmt: skip

    def perform_shown(self, performer: Performer | None = None) -> Animation:
        """Perform the shown part of the line with its gestures."""
        return self.perform(performer, gestures=self.gestures)

    def lines(self) -> list[tuple[str, str]]:
        """Return the lines of the open language with their characters: of the script, or kept."""
        language, character = self.opened_pair()
        found = self.script.named(language, character)
        return found or [(name, character) for name in self._kept()]

    def _kept(self) -> dict[str, str]:
        """Return the texts of the lines that the character keeps in the open language, by name."""
        rows, language = self._stated.items(), self.opened_pair()[0]
        own = {name: line for name, line in rows if line.get("language") == language}
        return {name: line["text"] for name, line in own.items() if line.get("text")}

    def aside(self, name: str, character: str) -> "Workshop":
        """Return a workshop with the same packs and edits, and another line open in it."""
        if (name, character) == (self.name, self.opened_pair()[1]) and self.line is not None:
            return self
        # A shallow copy shares packs, desk and caches; only what opening a line sets is its own.
        other = copy(self)
        if character != self.opened_pair()[1]:
            other.open(self.language, character)
        if other.script.has(name):
            other.open_script_line(name)
        elif "text" in other._stated.get(name, {}):  # noqa: SLF001 of its own class
            other.speak(other._stated[name]["text"])  # noqa: SLF001
        else:
            raise LipsyncError(f"there is no line '{name}'; open the dialog again")
        return other

    def state(self) -> Json:
        """Return the state for all views as JSON data."""
        desk = self.desk
        if self._followed != desk.revision:
            self.follow()
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
        compiled = self.performer.compiled
        poseset = self.library().poseset(compiled.poseset).model.having(compiled.poses)
        return data | {
            "poseset": compiled.poseset,
            "poses": [
                {"name": name, "title": pose.title or "", "region": pose.region or ""}
                for name, pose in poseset.poses.items()
            ],
            "phonemes": list(compiled.phonemes),
            "measures": compiled.measures,
            "regions": compiled.regions,
            "styles": list(compiled.style_names),
            "lines": list(compiled.line_edits),
            "kept": [text for name, text in self._kept().items() if not self.script.has(name)],
            "text": self.text,
            "settings": asdict(self.settings),
            "line": self.line is not None,
            "name": self.name,
            "opened": self.opened,
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


def without_lines(performer: Performer) -> Performer:
    """Return a performer that leaves lines to its caller, except the scales of their gestures."""
    compiled = performer.compiled
    scales = {
        name: {"gestures": line["gestures"]} for name, line in compiled.line_deliveries.items()
    }
    return replace(performer, compiled=replace(compiled, line_deliveries=scales))
