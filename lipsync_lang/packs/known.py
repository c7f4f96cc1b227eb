"""The common phonemes of all languages together."""

from collections.abc import Callable, Collection, Iterator
from functools import cached_property
from typing import TYPE_CHECKING

from lipsync_lang.errors import PackError

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library


class KnownPhonemes(Collection[str]):
    """Phonemes of every language, loaded lazily.

    Loading every language is slow, so `in` does so only for a label missing from `common`.

    Parameters
    ----------
    common : phonemes of the common pack
    more : returns the phonemes that languages add
    """

    def __init__(self, common: set[str], more: Callable[[], set[str]]) -> None:
        self._common, self._more = common, more

    @cached_property
    def _whole(self) -> set[str]:
        return self._common | self._more()

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


def known(library: "Library", common: Collection[str]) -> KnownPhonemes:
    """Return the phonemes of every language in a library."""

    def added() -> set[str]:
        names = {found.name for found in library.names("language")}
        return set().union(*(added_by(library, name) for name in sorted(names)))

    return KnownPhonemes(set(common), added)
