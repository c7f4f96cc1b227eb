"""Unsaved edits of pack files: undone, kept in a journal, merged with the disk, and saved.

A desk identifies files by absolute path, and reads a file at its first edit. Each edit sets,
inserts or deletes a value at a location; every text in between is a valid pack. Texts share the
parts that an edit does not change, so the number of undo steps is unlimited.
"""

import os
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from weakref import finalize

from lipsync_lang.errors import LipsyncError, OutputError, PackError
from lipsync_lang.files.locking import claim
from lipsync_lang.files.temporary import sweep
from lipsync_lang.json_object import Json
from lipsync_lang.packs.splicing import SplicedText, get
from lipsync_lang.packs.yaml.faults import shown
from lipsync_lang.packs.yaml.source import Loc
from lipsync_lang.studio.edit_journal import (
    JournalError,
    JournalKeeper,
    digest,
    edit_of,
    line_of,
    put_aside,
    read_journal,
    save_line,
)
from lipsync_lang.studio.editable_files import refuse, shipped_folders, write_together
from lipsync_lang.studio.merging import (
    Choices,
    EditConflict,
    MergeConflict,
    SaveConflict,
    differences,
    overlap,
    told,
)
from lipsync_lang.studio.sheets import (
    EditedFile,
    PackEdit,
    Plan,
    Step,
    TextParts,
    by_file,
    in_parts,
    on_disk,
    planned,
    rebase,
)

RESTORED = "restored edits"
"""Title of a step that a journal stores as a whole text."""

PlannedSave = tuple[EditedFile, bytes | None, Plan]
"""A file to save, its content on the disk, and what to write."""

MAX_TOUCHED = 10_000
"""Maximum number of edits in memory for conflicts between tabs."""


class Desk:
    r"""Files with unsaved edits.

    Parameters
    ----------
    journal : file of unsaved edits; None keeps them only in memory
    shipped : folders whose files are never edited; None is those of installed distributions

    Attributes
    ----------
    revision : grows by each change
    restored : number of edits found in the journal
    notes : messages to the user about the journal

    Example
    -------
    >>> desk = Desk(None)
    >>> bank = Path("/nowhere/b.yaml")
    >>> text = "kind: bank\nformat: 1\nname: b\nposeset: f\nbigrams: {}\n"
    >>> desk.change("Make a bank", [(bank, ("style",), "sad")], create={bank: text})
    >>> desk.undo_title, desk.unsaved()[0][1:]
    ('Make a bank', (('kind',), 'added'))
    """

    def __init__(self, journal: Path | None, *, shipped: Iterable[Path] | None = None) -> None:
        self.revision = 0
        self.restored = 0
        self.notes: list[str] = []
        self._sheets: dict[Path, EditedFile] = {}
        self._done: list[Step] = []
        self._undone: list[Step] = []
        self._touched: deque[tuple[int, str, Path, Loc]] = deque(maxlen=MAX_TOUCHED)
        self._shipped = shipped_folders() if shipped is None else tuple(shipped)
        self._journal: JournalKeeper | None = None
        self._replaying = False
        self._begun: dict[str, str] = {}
        """The save in the journal: its files, with the digests of what they held before."""
        held = None if journal is None else claim(journal.with_name(f"{journal.name}.lock"))
        if held is not None:
            finalize(self, os.close, held)
        if journal is not None and held is None:
            self.notes.append(
                "another studio of this project is running and keeps the unsaved edits; save here "
                "before you close this studio, or its edits are lost"
            )
        elif journal is not None:
            lines = self._restore(journal)
            self._journal = JournalKeeper(journal, lines, {*self._sheets})
            for folder in {journal.parent, *(path.resolve().parent for path in self._sheets)}:
                sweep(folder, again=True)  # what a killed studio left
            if self._begun:
                self._complete(self._begun)

    # What there is

    @property
    def journaled(self) -> bool:
        """True if this desk keeps the journal; another studio of the project may have it."""
        return self._journal is not None

    @property
    def undo_title(self) -> str | None:
        """Title of the step that `undo` reverts."""
        return self._done[-1].title if self._done else None

    @property
    def redo_title(self) -> str | None:
        """Title of the step that `redo` repeats."""
        return self._undone[-1].title if self._undone else None

    @property
    def contents(self) -> Mapping[Path, bytes]:
        """Text of every file with unsaved edits, for `Library(unsaved=...)`."""
        return {path: sheet.text.content for path, sheet in self._sheets.items() if sheet.edited}

    def content(self, path: Path) -> bytes | None:
        """Return the text of a file with its edits; None if the file has no edits."""
        sheet = self._sheets.get(path)
        return sheet.text.content if sheet is not None and sheet.text.parts else None

    def text(self, path: Path) -> SplicedText | None:
        """Return the parts of a file with its edits; None if the file has no edits."""
        sheet = self._sheets.get(path)
        return sheet.text if sheet is not None and sheet.text.parts else None

    def unsaved(self) -> list[tuple[Path, Loc, str]]:
        """List every entry that differs from the disk: file, location, and kind of change."""
        return [
            (path, loc, told(get(sheet.saved.data, loc), value))
            for path, sheet in self._sheets.items()
            if sheet.edited
            for loc, value in differences(sheet.saved.data, sheet.text.data)
        ]

    # Edits

    def read(self, path: Path) -> None:
        """Load a file before its first edit, to make that edit faster."""
        self._sheets.setdefault(path, self._sheet(path))

    def change(  # noqa: PLR0913 the fields of an edit
        self,
        title: str,
        edits: Sequence[PackEdit],
        *,
        seen: int | None = None,
        tab: str = "",
        merge: str = "",
        create: Mapping[Path, str] | None = None,
        check: Callable[[Mapping[Path, SplicedText]], None] | None = None,
    ) -> None:
        """Set, insert or delete values, either all or none.

        Parameters
        ----------
        title : name of the change for undo
        seen : revision that the tab has shown; None accepts any
        tab : the tab that asks
        merge : successive changes of one tab with the same key are undone as one
        create : text of files that do not exist yet
        check : receives the changed files before the edit; its error refuses the edits

        Raises
        ------
        EditConflict
            Another tab changed a location after `seen`.
        PackFaults
            A pack would be faulty; nothing changes.
        LipsyncError
            A file cannot be read, or must not be edited.
        """
        create = create or {}
        locs = [(path, tuple(loc)) for path, loc, _ in edits]
        self._refuse_conflicts(locs, seen, tab)
        sheets = {path: self._sheet(path) for path in [*create, *(path for path, _ in locs)]}
        texts = _edited(sheets, edits, create)
        self._sheets |= sheets
        before = {path: sheets[path].text.parts for path in texts}
        after = {path: text.parts for path, text in texts.items()}
        if all(before[path] is after[path] for path in after):
            return
        if check is not None:
            check(texts)
        self._put(texts)
        step = self._add(Step(title, merge, tab, locs, before, after))
        self._touch(locs, tab)
        self._write(
            step,
            {
                "change": title,
                "merge": merge,
                "tab": tab,
                "edits": [line_of(edit) for edit in edits],
                "create": {str(path): text for path, text in create.items()},
            },
        )

    def undo(self, *, tab: str = "") -> str:
        """Undo the latest step, and return its title.

        Raises
        ------
        LipsyncError
            There is nothing to undo.
        """
        if not self._done:
            raise LipsyncError("there is nothing to undo")
        step = self._done.pop()
        self._undone.append(step)
        return self._back_to(step, step.before, {"undo": step.title}, tab)

    def redo(self, *, tab: str = "") -> str:
        """Redo the step that was undone last, and return its title.

        Raises
        ------
        LipsyncError
            There is nothing to redo.
        """
        if not self._undone:
            raise LipsyncError("there is nothing to redo")
        step = self._undone.pop()
        self._done.append(step)
        return self._back_to(step, step.after, {"redo": step.title}, tab)

    def _back_to(self, step: Step, parts: Mapping[Path, TextParts], line: Json, tab: str) -> str:
        self._put({path: SplicedText(path, some) for path, some in parts.items()})
        self._touch(step.locs, tab)
        self._write(step, line)
        return step.title

    def _add(self, step: Step) -> Step:
        """Add a step, or join it to the latest; return the latest."""
        last = self._done[-1] if self._done and not self._undone else None
        self._undone.clear()
        alike = last is not None and (last.merge, last.tab) == (step.merge, step.tab)
        if last is None or not step.merge or not alike or not last.journaled:
            self._done.append(step)
            return step
        last.before = {**step.before, **last.before}
        last.after |= step.after
        last.locs = list(dict.fromkeys([*last.locs, *step.locs]))
        return last

    def _put(self, texts: Mapping[Path, SplicedText]) -> None:
        for path, text in texts.items():
            sheet = self._sheets[path]
            sheet.text = sheet.saved if text.parts is sheet.saved.parts else text

    def _touch(self, locs: Iterable[tuple[Path, Loc]], tab: str) -> None:
        self.revision += 1
        self._touched.extend((self.revision, tab, path, loc) for path, loc in locs)

    def _refuse_conflicts(
        self, locs: Sequence[tuple[Path, Loc]], seen: int | None, tab: str
    ) -> None:
        """Raise `EditConflict` if another tab changed a location after the revision seen."""
        for revision, other, path, loc in self._touched if seen is not None else ():
            if revision <= (seen or 0) or other == tab:
                continue
            for own_path, own in locs:
                if path == own_path and overlap(loc, own):
                    where = "-".join(map(str, loc[1:2] or loc))
                    raise EditConflict(
                        f"another tab has changed {where} of {shown(path)}; "
                        "check the change, and edit again"
                    )

    def _sheet(self, path: Path) -> EditedFile:
        """Return a file, which is read first if it has no edits yet."""
        sheet = self._sheets.get(path)
        if sheet is not None and sheet.edited:
            return sheet
        if sheet is None and not self._replaying:
            self._refuse(path)
        if self._replaying:
            if sheet is None:
                raise JournalError("is damaged: an edit precedes the text of its file")
            return sheet
        disk = on_disk(path)
        if sheet is not None and sheet.base == disk:
            return sheet
        saved = in_parts(path, disk)
        if sheet is not None:
            self._rebase(sheet, saved, saved)
        return EditedFile(path, disk, saved, saved)

    def _refuse(self, path: Path) -> None:
        refuse(path, self._shipped, self._sheets)

    # Saving

    def save(self, files: Iterable[Path] | None = None, keep: Choices | None = None) -> list[Path]:
        """Write the edits of some files, or of all, and return the files written.

        A file that changed on the disk keeps those changes; the edits are applied to it.

        Parameters
        ----------
        keep : the side to keep of each conflict that an earlier call raised, by file and location

        Raises
        ------
        SaveConflict
            An entry was edited here and changed on the disk; nothing is written.
        PackFaults
            A file is faulty on the disk, or would be with the edits; nothing is written.
        OutputError
            A file cannot be written; no file changes.
        """
        wanted = self.contents if files is None else set(files)
        sheets = [sheet for path, sheet in self._sheets.items() if path in wanted and sheet.edited]
        conflicts: list[MergeConflict] = []
        plans = []
        for sheet in sheets:
            self._refuse(sheet.path)
            disk = on_disk(sheet.path)
            plan = planned(sheet, disk, keep or {})
            conflicts += plan.conflicts
            plans.append((sheet, disk, plan))
        if conflicts:
            raise SaveConflict(conflicts)
        written = {
            sheet.path: plan.text.content
            for sheet, disk, plan in plans
            if plan.text.parts and plan.text.content != disk
        }
        try:
            write_together(written, lambda: self._begin(plans, written))
        except OutputError:
            self._settle(plans)
            with suppress(OutputError):
                self._compact()
            raise
        self._settle(plans)
        self._compact()
        return list(written)

    def _begin(self, plans: Sequence[PlannedSave], written: Collection[Path]) -> None:
        """Note a save in the journal: from now on it is completed, whatever happens."""
        if self._journal is None:
            return
        saving = []
        for sheet, _, plan in plans:
            if sheet.path in written:
                base = plan.theirs.content if plan.theirs.parts else None
                saving.append(EditedFile(sheet.path, base, plan.theirs, plan.text))
        named = {sheet.path for sheet, _, _ in plans}
        others = [one for path, one in self._sheets.items() if one.edited and path not in named]
        before = {sheet.path: disk for sheet, disk, _ in plans if sheet.path in written}
        self._journal.rewrite([*saving, *others], save_line(before))

    def _complete(self, begun: Mapping[str, str]) -> None:
        """Complete the save in the journal; a file that has changed since then stays unsaved."""
        sheets = [self._sheets[Path(path)] for path in begun]
        due = [sheet for sheet in sheets if digest(on_disk(sheet.path)) == begun[str(sheet.path)]]
        try:
            for sheet in due:
                self._refuse(sheet.path)
            write_together({sheet.path: sheet.text.content for sheet in due}, lambda: None)
        except OutputError as error:
            self.notes.append(f"a save was cut off, and cannot be completed: {error}")
        saved = [sheet for sheet in sheets if on_disk(sheet.path) == sheet.text.content]
        for sheet in saved:
            self._sheets[sheet.path] = EditedFile(
                sheet.path, sheet.text.content, sheet.text, sheet.text
            )
        self.restored -= len(saved)
        self.notes += [
            f"{shown(sheet.path)}: its save was cut off, and is complete" for sheet in saved
        ]
        self._compact()

    def _settle(self, plans: Iterable[PlannedSave]) -> None:
        """Count as saved what the disk holds now."""
        for sheet, disk, plan in plans:
            text = plan.text
            base = text.content if text.parts else None
            if on_disk(sheet.path) == base:
                if disk != sheet.base:
                    self._rebase(sheet, plan.theirs, text, plan.dropped)
                self._sheets[sheet.path] = EditedFile(sheet.path, base, text, text)

    def _rebase(
        self, sheet: EditedFile, theirs: SplicedText, now: SplicedText, dropped: Sequence[Loc] = ()
    ) -> None:
        """Merge changes on the disk into every text that undo and redo reach."""
        taken = differences(sheet.saved.data, theirs.data)
        if self._journal is not None:
            self._journal.stale = True
        self._touch([(sheet.path, loc) for loc, _ in taken], "")
        try:
            rebase([*self._done, *reversed(self._undone)], sheet, theirs, now, dropped)
        except PackError:  # an older text does not take the change
            self._done.clear()
            self._undone.clear()
            where = shown(sheet.path)
            self.notes.append(f"{where} changed on the disk; earlier steps cannot be undone")

    # The journal

    def _write(self, step: Step, line: Json) -> None:
        """Keep an edit in the journal."""
        if self._journal is None:
            return
        if self._journal.full or not step.journaled:
            self._compact()
        else:
            self._journal.add(line, self._sheets.values())

    def _compact(self) -> None:
        """Write the journal again: the files with unsaved edits, without steps."""
        if self._journal is None:
            return
        self._journal.rewrite(sheet for sheet in self._sheets.values() if sheet.edited)
        for step in [*self._done, *self._undone]:
            step.journaled = False

    def _restore(self, journal: Path) -> int:
        """Restore the edits of a journal, and count its lines; a damaged journal is renamed."""
        lines: list[Json] = []
        try:
            lines = read_journal(journal)
            self._replaying = True
            for line in lines:
                self._replay(line)
        except (LipsyncError, KeyError, TypeError, ValueError) as error:
            self._sheets.clear()
            self._done.clear()
            self._undone.clear()
            self._touched.clear()
            lines = []
            why = str(error) if isinstance(error, LipsyncError) else "is damaged"
            try:
                where = f"it is kept as {put_aside(journal)}"
            except OSError as failed:
                raise OutputError(f"{journal}: {why}, and cannot be renamed: {failed}") from None
            self.notes.append(f"{journal}: {why}; no edits are restored, and {where}")
        finally:
            self._replaying = False
        self.restored = len(self._done)
        return len(lines)

    def _replay(self, line: Json) -> None:
        """Repeat one line of a journal."""
        if "base" in line:
            path, text = Path(line["base"]), line["text"]
            base = None if text is None else text.encode()
            saved = in_parts(path, base)
            self._sheets[path] = EditedFile(path, base, saved, saved)
        elif "put" in line:
            sheet = self._sheets[Path(line["put"])]
            after = SplicedText.read(sheet.path, line["text"].encode()).checked()
            locs = [(sheet.path, loc) for loc, _ in differences(sheet.saved.data, after.data)]
            sides = {sheet.path: sheet.text.parts}, {sheet.path: after.parts}
            self._put({sheet.path: after})
            self._add(Step(RESTORED, "", "", locs, *sides, journaled=True))
            self._touch(locs, "")
        elif "change" in line:
            edits = [edit_of(one) for one in line["edits"]]
            create = {Path(path): text for path, text in line["create"].items()}
            more = {"tab": line["tab"], "merge": line["merge"], "create": create}
            self.change(line["change"], edits, **more)
        elif "save" in line:
            self._begun = {
                str(self._sheets[Path(one)].path): was for one, was in line["save"].items()
            }
        elif "undo" in line:
            self.undo()
        elif "redo" in line:
            self.redo()
        else:
            raise JournalError("has lines from a newer version")


def _edited(
    sheets: Mapping[Path, EditedFile], edits: Sequence[PackEdit], create: Mapping[Path, str]
) -> dict[Path, SplicedText]:
    """Return the texts of files after edits."""
    texts = {path: sheet.text for path, sheet in sheets.items()}
    for path, initial in create.items():
        if not texts[path].parts:
            texts[path] = SplicedText.read(path, initial.encode()).checked()
    for path, changes in by_file(edits).items():
        if not texts[path].parts:
            raise PackError(f"{shown(path)}: no such file; open the pair again")
        texts[path] = texts[path].changed(changes)
    return texts
