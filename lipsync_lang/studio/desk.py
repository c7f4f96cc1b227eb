"""Unsaved edits of pack files: undone, kept in a journal, merged with the disk, and saved.

A desk has the saved text of each file, and two lists: steps, each of some changes, and the texts
before the first and after each. Texts share the parts that an edit does not change, so the number
of steps is unlimited. A change is JSON, and a line of the journal, from which the studio restores
the edits after a crash. A save notes there that it begins, so that the next start completes it.
"""

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from operator import methodcaller
from pathlib import Path
from typing import Any, Self
from weakref import finalize

from lipsync_lang.base.errors import LipsyncError, OutputError, PackError
from lipsync_lang.base.files import atomic, read_input, write_all
from lipsync_lang.base.files.locking import claim
from lipsync_lang.base.files.targets import file_behind
from lipsync_lang.base.files.writing import cannot_write, replace_file
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.finding import Finder
from lipsync_lang.packs.splicing import ABSENT, SplicedText, plain
from lipsync_lang.packs.yaml.pack_files import read_bytes, shown
from lipsync_lang.packs.yaml.source import Loc
from lipsync_lang.resolver.retouch import OpenPair
from lipsync_lang.studio.merging import (
    Choices,
    EditConflict,
    SaveConflict,
    differences,
    merged,
    overlap,
)

PackEdit = tuple[Path, Loc, Any]
"""File, location and new value: `ABSENT` deletes an entry, and () is the text of a new file."""

Texts = dict[Path, SplicedText]
"""Texts of files; one without parts is of a file that does not exist."""

JOURNAL_HEADER = {"journal": "lipsync-lang studio", "format": 1}
"""First line of a journal."""

RESTORED = {"change": "restored edits", "merge": "", "tab": ""}
"""Title of a step that a journal states as a whole text."""

MAX_JOURNAL_BYTES = 64 * 2**20
"""Maximum size of a journal."""

MAX_JOURNALED = 250
"""Number of steps in a journal; the next start of the studio takes 10 ms for each."""


def refuse(path: Path, shipped: Iterable[Path], others: Iterable[Path]) -> None:
    """Raise `OutputError` for a file in a folder of `shipped` packs, or among `others` with edits.

    A file is edited under one name only.
    """
    if not path.is_absolute() or path.suffix != ".yaml":
        raise OutputError(
            f"{path}: is not the file of a pack; give an absolute path with the suffix .yaml"
        )
    # Links may lead into the installed packs, or give one file two names.
    real = Path(os.path.realpath(path))
    folder = next((root for root in shipped if real.is_relative_to(root)), None)
    if folder is not None:
        raise OutputError(
            f"{shown(path)}: belongs to an installed distribution, whose updates undo edits; "
            f"copy it to {real.relative_to(folder)} in your project and edit it there"
        )
    try:
        file_behind(path)
    except OSError as error:
        raise OutputError(f"{shown(path)}: {error.strerror or error}") from None
    other = next((p for p in others if p != path and Path(os.path.realpath(p)) == real), None)
    if other is not None:
        raise OutputError(f"{shown(path)}: is the same file as {shown(other)}; edit that one")


def write_together(
    contents: Mapping[Path, bytes | None], ready: Callable[[], object] = bool
) -> None:
    """Write all files or none, and create missing folders; None deletes a file.

    For `ready` see `write_all`.
    """
    for path in contents:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(path.parent, error) from None
    kept = {path: content for path, content in contents.items() if content is not None}
    outputs = {path: methodcaller("write", content) for path, content in kept.items()}
    write_all(outputs, durable=True, ready=ready)
    for path in contents.keys() - kept.keys():
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise cannot_write(path, error) from None


class Desk:
    r"""Files with unsaved edits, by their absolute paths.

    `journal` is the file that keeps the edits; None keeps them only in memory. Files in the folders
    `shipped` are never edited; None stands for those of installed distributions. `revision` grows
    by each change, `restored` is the number of steps found in the journal, and `notes` are messages
    to the user about it. `journal` is None as well while another studio of the project has it.

    >>> desk = Desk(None)
    >>> bank = Path("/nowhere/b.yaml")
    >>> text = "kind: bank\nformat: 1\nname: b\nposeset: f\nbigrams: {}\n"
    >>> desk.change("Make a bank", [(bank, (), text), (bank, ("style",), "sad")])
    >>> desk.undo_title, desk.unsaved()[0][1:]
    ('Make a bank', (('kind',), 'added'))
    """

    def __init__(self, journal: Path | None, *, shipped: Iterable[Path] | None = None) -> None:
        self.revision = self.restored = 0
        self.notes: list[str] = []
        self.journal: Path | None = None
        if shipped is None:  # the pack folders of installed distributions, and the built-in packs
            roots, origins = Finder().roots, ("built-in", "installed")
            shipped = [root.path.resolve() for root in roots if root.origin.startswith(origins)]
        self._shipped = tuple(shipped)
        self._saved: Texts = {}
        self._steps: list[list[Json]] = []
        self._states: list[Texts] = [{}]
        self._at = self._old = 0
        """Numbers of the present state, and of the first one in the journal."""
        self._touched: dict[tuple[Path, Loc], tuple[int, str]] = {}
        """Revision and tab of the last change of each location."""
        held = None if journal is None else claim(journal.with_name(f"{journal.name}.lock"))
        if journal is not None and held is not None:
            # The lock ends with the desk, also if it is only forgotten, as in a test.
            finalize(self, os.close, held)
            self._restore(journal)
        elif journal is not None:
            self.notes.append(
                "another studio of this project is running and keeps the unsaved edits; save here "
                "before you close this studio, or its edits are lost"
            )

    @property
    def undo_title(self) -> str | None:
        """Title of the step that `undo` reverts."""
        return self._steps[self._at - 1][-1]["change"] if self._at else None

    @property
    def redo_title(self) -> str | None:
        """Title of the step that `redo` repeats."""
        return next((step[-1]["change"] for step in self._steps[self._at :]), None)

    @property
    def _texts(self) -> Texts:
        return self._states[self._at]

    @property
    def contents(self) -> Mapping[Path, bytes]:
        """Text of every file with unsaved edits, for `Library(unsaved=...)`."""
        texts = ((path, text.content) for path, text in self._texts.items())
        return {path: text for path, text in texts if text != self._saved[path].content}

    def text(self, path: Path) -> SplicedText | None:
        """Return the present text of a file; None if it was not read, or does not exist."""
        text = self._texts.get(path)
        return text if text is not None and text.parts else None

    def unsaved(self) -> list[tuple[Path, Loc, str]]:
        """List every entry that differs from the disk: file, location, and kind of change."""
        return [
            (path, loc, "added" if saved.at(loc) is ABSENT else told)
            for path, saved in self._saved.items()
            for loc, value in differences(saved.data, self._texts[path].data)
            for told in ["deleted" if value is ABSENT else "changed"]
        ]

    # Steps

    def read(self, path: Path) -> None:
        """Read a file before its first edit, and again as long as it has no edits."""
        if path not in self._saved:
            refuse(path, self._shipped, self._saved)
        # A file with edits keeps the text that they were made on; saving merges it with the disk.
        elif path in self.contents or _on_disk(path) == self._saved[path].content:
            return
        text = _parsed(path, _on_disk(path))
        self._take(path, text, text)

    def change(  # noqa: PLR0913 the fields of an edit
        self,
        title: str,
        edits: Sequence[PackEdit],
        *,
        seen: int | None = None,
        tab: str = "",
        merge: str = "",
        check: Callable[[Texts], object] = bool,
    ) -> None:
        """Set, insert or delete values, either all or none.

        `title` names the change for undo. `tab` asks for it, and has shown the revision `seen`;
        None accepts any. Successive changes of one tab with the same key `merge` are undone as one.
        `check` receives the changed texts before the edit; its error refuses the edits.

        Raises EditConflict if another tab changed a location after `seen`, PackFaults if a pack
        would be faulty, and LipsyncError for a file that cannot be read or must not be edited.
        """
        for (file, at), (revision, by) in self._touched.items() if seen is not None else ():
            late = revision > (seen or 0) and by != tab
            if late and any(path == file and overlap(loc, at) for path, loc, _ in edits):
                raise EditConflict(
                    f"another tab has changed {at[:2][-1]} of {shown(file)}; look, and edit again"
                )
        stated: list[Json] = []
        for path, loc, value in edits:
            self.read(path)
            if loc or self.text(path) is None:  # else somebody has made the file
                edit = {"file": str(path), "at": [*loc], "value": plain(value)}
                stated.append({key: one for key, one in edit.items() if one is not ABSENT})
        self._do({"change": title, "merge": merge, "tab": tab, "edits": stated}, check)

    def undo(self, *, tab: str = "") -> str:
        """Undo the latest step, and return its title; raise LipsyncError if there is none."""
        return self._do({"undo": self.undo_title, "tab": tab})

    def redo(self, *, tab: str = "") -> str:
        """Redo the step undone last, and return its title; raise LipsyncError if there is none."""
        return self._do({"redo": self.redo_title, "tab": tab})

    def _do(self, line: Json, check: Callable[[Texts], object] = bool) -> str:
        """Do an operation, of now or of the journal, and return the title of its step."""
        texts, at = self._texts, self._at - ("undo" in line)
        if "undo" in line or "redo" in line:
            if not 0 <= at < len(self._steps):
                raise LipsyncError(f"there is nothing to {next(iter(line))}")
            self._at = at + ("redo" in line)
        else:
            new, step = _edited(texts, line), [{**RESTORED, **line}]
            if new == texts:
                return ""
            check({path: text for path, text in new.items() if text is not texts[path]})
            last = self._steps[-1][-1] if self._old < at == len(self._steps) else RESTORED
            if line.get("merge") and all(line[key] == last[key] for key in ("merge", "tab")):
                # A move of a drag takes the place of the move before, if it sets the same.
                moves = [*_edits(last), *_edits(line)]
                again = all(loc and value is not ABSENT for _, loc, value in moves)
                again &= _places([last]) == _places([line])
                at -= 1
                step = [*self._steps[at][: -1 if again else None], *step]
            # A new step drops the steps that were undone.
            self._steps[at:], self._states[at + 1 :] = [step], [new]
            self._at, self._old = at + 1, max(min(self._old, at), at + 1 - MAX_JOURNALED)
        self.revision += 1
        mark = self.revision, line.get("tab", "")
        # Undo and redo touch the same places as the step itself, so other tabs are warned as well.
        self._touched |= dict.fromkeys(_places(self._steps[at]), mark)
        self._keep()
        return str(self._steps[at][-1]["change"])

    def _take(self, path: Path, saved: SplicedText, text: SplicedText) -> None:
        """Go on from a text of the disk, with its changes in all texts that undo and redo reach."""
        old = self._saved.get(path, saved)
        self._saved[path] = saved
        for texts in self._states:
            # Each state has all files, so that undo across them finds a text for each.
            texts.setdefault(path, text)
        if old is not saved:
            self._old = len(self._steps)
            self.revision += 1
            taken = [(path, loc) for loc, _ in differences(old.data, saved.data)]
            self._touched |= dict.fromkeys(taken, (self.revision, ""))
            # Texts are compared by identity: each state that shares one gets the same new one,
            # which keeps the memory of a long undo list small.
            made = {old: saved, self._texts[path]: text}
            for texts in self._states:
                before, old = old, texts[path]
                if old not in made:
                    made[old] = made[before]
                    with suppress(PackError):  # else the step changes nothing
                        made[old], _ = merged(before, old, made[before], {})
                texts[path] = made[old]

    # Saving

    def save(self, keep: Choices | None = None) -> list[Path]:
        """Write all edits, and return the files written.

        A file that changed on the disk keeps those changes; the edits are applied to it. `keep` has
        the side of each conflict that an earlier call raised, by file and location.

        Raises SaveConflict if an entry was edited here and changed on the disk, PackFaults for a
        file that is faulty there, or would be with the edits, and OutputError for one that cannot
        be written; no file changes.
        """
        theirs, texts, conflicts = {}, {}, []
        for path in self.contents:
            refuse(path, self._shipped, self._saved)
            choices = {loc: side for (file, loc), side in (keep or {}).items() if file == path}
            theirs[path], disk = self._saved[path], _on_disk(path)
            if disk != theirs[path].content and choices.get(()) != "mine":
                theirs[path] = _parsed(path, disk)
            texts[path], more = merged(self._saved[path], self._texts[path], theirs[path], choices)
            conflicts += more
        # Before any file is written, so that a conflict leaves all of them alone.
        if conflicts:
            raise SaveConflict(conflicts)
        for path, text in texts.items():
            self._take(path, theirs[path], text)
        due = {path: t.content or None for path, t in texts.items() if t.content != _on_disk(path)}
        try:
            write_together(due, lambda: self._keep({"save": [*map(str, due)]}))
        finally:
            self._saved |= {path: t for path, t in texts.items() if t.content == _on_disk(path)}
            self._old = len(self._steps)
            self._keep()
        return [*due]

    # The journal

    def _keep(self, *more: Json) -> None:
        """Write the journal: the texts of files at a state, and the changes after it."""
        if self.journal is None:
            return
        start, *later = self._states[min(self._at, self._old) :]
        steps = self._steps[self._old :] if self._old <= self._at else []
        lines: list[Json] = []
        for path, saved in self._saved.items():
            if any(texts[path] is not saved for texts in (start, *later[: len(steps)])):
                lines.append({"base": str(path), "text": saved.content.decode()})
            if start[path].content != saved.content:
                lines.append({"put": str(path), "text": start[path].content.decode()})
        lines += [line for step in steps for line in step]
        # Steps that can be redone are kept as steps and their undoing.
        lines += [{"undo": ""}] * (len(self._steps) - self._at if steps else 0)
        with atomic(self.journal, durable=bool(more)) as stream:
            # The journal is written whole: appending would never drop steps that were saved.
            for line in (JOURNAL_HEADER, *lines, *more):
                row = json.dumps(line, ensure_ascii=False, separators=(",", ":"))
                stream.write(row.encode() + b"\n")

    def _restore(self, journal: Path) -> None:
        """Restore the edits of a journal, and save them if a save was cut off."""
        begun = False
        try:
            mend = "its edits cannot be restored"
            content = read_input(journal, MAX_JOURNAL_BYTES, mend=mend) if journal.exists() else b""
            lines = [{**json.loads(row)} for row in content.split(b"\n")[:-1]]  # the rest is torn
            if content and lines[:1] != [JOURNAL_HEADER]:
                raise LipsyncError("is not a journal of the studio")  # noqa: TRY301 told below
            for line in lines[1:]:
                if "base" in line:
                    text = _parsed(Path(line["base"]), bytes(line["text"] or "", "utf-8"))
                    self._take(text.path, text, text)
                elif "save" in line:
                    begun = True
                else:
                    self._do(line)
        except (LipsyncError, LookupError, RecursionError, TypeError, ValueError) as error:
            # Nothing of a damaged journal is kept: some edits may make no sense without the rest.
            self._saved, self._touched, self._steps, self._states, self._at = {}, {}, [], [{}], 0
            why = error if isinstance(error, LipsyncError) else "is damaged, or of a newer version"
            aside = journal.with_name(f"{journal.name}.damaged-{os.urandom(4).hex()}")
            self.notes.append(f"{journal}: {why}; no edits are restored, and it is kept as {aside}")
            try:
                replace_file(journal, aside)
            except OSError as failed:
                raise OutputError(f"{journal}: {why}, and cannot be renamed: {failed}") from None
            begun, self._old = False, 0
        self.journal = journal
        try:
            for path in self.save() if begun else ():
                self.notes.append(f"{shown(path)}: its save was cut off, and is complete")
        except LipsyncError as error:
            self.notes.append(f"a save was cut off, and cannot be completed: {error}")
            self._keep()
        self.restored = self._at if self.contents else 0


def _edits(line: Json) -> list[PackEdit]:
    """Return the edits of a change; an older version stated new files beside them."""
    new = {line["put"]: line["text"]} if "put" in line else line.get("create", {})
    rows = [{"file": path, "at": (), "value": text} for path, text in dict(new).items()]
    rows += [] if "put" in line else line["edits"]
    return [(Path(row["file"]), tuple(row["at"]), row.get("value", ABSENT)) for row in rows]


def _edited(texts: Texts, line: Json) -> Texts:
    """Return texts after a change."""
    after, edits = dict(texts), _edits(line)
    for path, loc, value in edits:
        if not loc:
            after[path] = _parsed(path, bytes(value, "utf-8")).checked()
    for path in dict.fromkeys(path for path, loc, _ in edits if loc):
        if not after[path].parts:
            raise PackError(f"{shown(path)}: no such file; open the pair again")
        changes = [(loc, value) for file, loc, value in edits if loc and file == path]
        after[path] = after[path].changed(changes)
    return after


def _places(step: Sequence[Json]) -> set[tuple[Path, Loc]]:
    return {(path, loc) for change in step for path, loc, _ in _edits(change) if loc}


def _on_disk(path: Path) -> bytes:
    """Return the content of a file; nothing for a missing one."""
    return read_bytes(path) if path.exists() else b""


def _parsed(path: Path, content: bytes) -> SplicedText:
    """Return a text in parts; a missing file has none."""
    return SplicedText.read(path, content) if content else SplicedText(path, ())


@dataclass(frozen=True, eq=False)
class EditedPair:
    """A compiled pair, with the files and unsaved texts that it depends on besides bigrams."""

    pair: OpenPair
    revision: int
    """Revision of the desk."""
    beside: Mapping[Path, bytes]
    """Unsaved contents of files without bigrams."""
    written: Mapping[Path, int | None]
    """Nanoseconds at which files without unsaved edits were written; None for a missing one."""

    @classmethod
    def of(cls, pair: OpenPair, desk: Desk) -> Self:
        """Note the files and texts on which a compiled pair depends."""
        return cls(pair, desk.revision, _beside(pair, desk.contents), _written(pair, desk.contents))

    def current(self, desk: Desk) -> Self | None:
        """Return the pair with the current edits; None if it must be compiled again."""
        texts = {path: text for path in self.pair.data if (text := desk.text(path)) is not None}
        made = self.changed(desk.contents, texts)
        return None if made is None else type(self).of(made, desk)

    def changed(
        self, contents: Mapping[Path, bytes], texts: Mapping[Path, SplicedText]
    ) -> OpenPair | None:
        """Return the pair with texts in place of its files; None if it must be compiled again.

        `contents` are all unsaved files, including the texts. Raises PackFaults if a bigram names
        an unknown phoneme or pose.
        """
        # Empty content stands for a deleted file.
        deleted = any(not contents.get(path, b"there") for path in self.pair.data)
        if deleted or _beside(self.pair, contents) != self.beside:
            return None
        for path, written in _written(self.pair, contents).items():
            gone = written is None and path in self.pair.data
            if gone or self.written.get(path, written) != written:
                return None
        return self.pair.retouched([text for path, text in texts.items() if path in self.pair.data])


def _beside(pair: OpenPair, contents: Mapping[Path, bytes]) -> dict[Path, bytes]:
    return {path: content for path, content in contents.items() if path not in pair.data}


def _written(pair: OpenPair, contents: Mapping[Path, bytes]) -> dict[Path, int | None]:
    """Return the modification times of files without unsaved edits."""
    files = {*map(Path, pair.shelf.library.files), *pair.data} - contents.keys()
    times: dict[Path, int | None] = dict.fromkeys(files)
    for path in files:
        with suppress(OSError):
            times[path] = path.stat().st_mtime_ns
    return times
