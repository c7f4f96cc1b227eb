"""Checks of the languages and characters that a project names."""

from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.packs.automatic import IPA_ENGINES
from lipsync_lang.packs.finding import Finder, Kind

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lipsync_lang.packs import models
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.faults import Fault
    from lipsync_lang.packs.yaml.source import Loc


def check_languages(project: "Pack[models.Project]", finder: Finder) -> "Iterator[Fault]":
    """Yield a fault for each unknown language, and for each that is stated twice."""
    stated = project.model
    places: list[tuple[Loc, str]] = [(("languages", name), name) for name in stated.languages]
    first: dict[str, str] = {}
    for loc, name in [*places, *([(("language",), stated.language)] if stated.language else [])]:
        found = finder.lookup("language", name)
        own = Path(found[0]).stem if found else name
        if not found and name.partition(":")[0] not in (IPA_ENGINES if ":" in name else ()):
            known = {one.name for one in finder.names("language")}
            yield project.unknown(loc, "P210", "language", name, known)
        # The default language may be one of the list.
        elif len(loc) > 1 and (other := first.setdefault(own, name)) != name:
            hint = (
                f"state it once; to make both, write a pack with a name of its own that states "
                f"`extends: {own}`"
            )
            what = f"{name} and {other} are the same language, {own}"
            yield project.fault(loc, "P402", what, hint)


def check_characters(project: "Pack[models.Project]", finder: Finder) -> "Iterator[Fault]":
    """Yield a fault for each unknown character."""
    stated = project.model
    places: list[tuple[Loc, str]] = [
        (("cast", speaker, number), name)
        for speaker, names in stated.cast.items()
        for number, name in enumerate(names)
    ]
    kinds: tuple[Kind, ...] = ("character", "poseset")
    for loc, name in [*places, *([(("character",), stated.character)] if stated.character else [])]:
        if not any(finder.lookup(kind, name) for kind in kinds):
            known = {one.name for kind in kinds for one in finder.names(kind)}
            yield project.unknown(loc, "P203", "character", name, known)
