"""The open pair with unsaved edits, updated in milliseconds while only bigrams change."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from lipsync_lang.packs.splicing import SplicedText
from lipsync_lang.resolver.retouch import OpenPair
from lipsync_lang.studio.desk import Desk


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
