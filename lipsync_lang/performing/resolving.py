"""Resolution of a language and a character into a performer.

Each ordered pair of common phonemes of the language is looked up in the layers that the package
`resolver` lists. Pairs without a match are gaps. A line that has one is an error by default; on
request it is at rest there.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import refuse_other
from lipsync_lang.packs.finding import Finder, Paths, is_model, located
from lipsync_lang.performing.label_reader import Unknown
from lipsync_lang.performing.performer import Performer
from lipsync_lang.performing.played_pair import Gaps
from lipsync_lang.resolver.compiled import CompiledPair
from lipsync_lang.resolver.settings import motion_with

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library


def resolve(  # noqa: PLR0913 two names, and options by keyword
    language: str | Path,
    character: str | Path,
    *,
    paths: Paths = (),
    gaps: Gaps = "error",
    unknown: Unknown = "nearest",
    motion: Mapping[str, object] | str | None = None,
    shades: bool | None = None,
    cache: bool = True,
) -> Performer:
    """Compose a language with a character.

    Parameters
    ----------
    language : name, tag, alias or file of a language pack; ENGINE:CODE for a language without one
    character : name or file of a character, or of a pose set for its default character; or a model
        (.glb, .vrm, .gltf), with the pose set and rig that fit its shapes best
    paths : one or several folders with priority in pack searches
    gaps : treatment of bigrams without a match that a line has: `error`, or `rest` with a remark
    unknown : treatment of unmapped labels: `error`, `rest`, or `nearest` for IPA, by its
        phonetic features; `Performer.automatic` names such labels, and others are an error
    motion : name of a preset, or changed settings of `Motion`
    shades : False to perform each shade as its parent; by default only the paper's thresholds do
    cache : True to read and write compiled pairs in the cache

    Raises
    ------
    PackError
        A pack is missing or invalid; the message lists every fault.
    ModelError
        The model is unreadable, or no pose set knows its shapes.
    LipsyncError
        An argument has an invalid value, or a motion setting is unknown.

    Examples
    --------
    >>> ll.resolve("english", "facefx", motion={"speed_limit": 8}).motion.speed_limit
    8.0
    """
    refuse_other("gaps", gaps, Gaps)
    refuse_other("unknown", unknown, Unknown)
    if is_model(character):
        (language,), folders = located(paths, language=language)
        # another pose set may fit the model better
        sets = (one.name for one in Finder(folders).names("poseset"))
        key, made = " + ".join((str(Path(character).resolve()), *sets)), _on_model
    else:
        (language, character), folders = located(paths, language=language, character=character)
        key, made = character, _pair
    from lipsync_lang.resolver import cache as store

    compiled = store.load(language, key, folders) if cache else None
    if compiled is None:
        from lipsync_lang.packs.library import Library

        library = Library(folders)
        compiled = made(library, language, str(character))
        if cache:
            store.save(compiled, language, key, library)
    moved = motion_with(compiled.motion, motion)
    return Performer(compiled, moved, unknown, folders, shades, gaps=gaps)


def _pair(library: "Library", language: str, character: str) -> CompiledPair:
    from lipsync_lang.resolver.compile import compile_pair

    return compile_pair(library, language, character)


def _on_model(library: "Library", language: str, character: str) -> CompiledPair:
    """Compile a language with the pose set that fits a model best."""
    from lipsync_lang.resolver.compile import compile_pair
    from lipsync_lang.resolver.rigging import best_match, on_model

    match, on = best_match(library, Path(character))
    pair = compile_pair(library, language, match.poseset, match.optional, on)
    return on_model(library, pair, match, Path(character))
