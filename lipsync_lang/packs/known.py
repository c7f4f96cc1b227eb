"""The common phonemes of all languages together."""

from collections.abc import Collection, Iterator
from functools import cached_property
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import PackError

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library


class KnownPhonemes(Collection[str]):
    """Some common phonemes, and those that any language of a library adds.

    Loading every language is slow, so `in` does so only for a label missing from `common`.
    """

    def __init__(self, library: "Library", common: set[str]) -> None:
        self._library, self._common = library, common

    @cached_property
    def _whole(self) -> set[str]:
        names = {found.name for found in self._library.names("language")}
        return self._common.union(*(added_by(self._library, name) for name in sorted(names)))

    def __contains__(self, name: object) -> bool:
        return name in self._common or name in self._whole

    def __iter__(self) -> Iterator[str]:
        return iter(self._whole)

    def __len__(self) -> int:
        return len(self._whole)


def added_by(library: "Library", language: str) -> set[str]:
    """Return the phonemes that a language adds; empty if its pack is faulty."""
    try:
        return set(library.language(language).model.adds)
    except PackError:
        return set()
