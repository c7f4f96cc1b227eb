"""Resolve: a language and a character become a performer.

Every ordered pair of the language's common phonemes is looked up in layers; the first that has
it wins, and the performer remembers where it came from:

1. the character's own bigrams and banks,
2. the language's banks for this pose set,
3. the pose set's shared banks,
4. the same pair, an added phoneme replaced by what it is `like`, in 1 to 3,
5. a draft from the pose set's phoneme targets.

What still has none is a gap, named; it is performed as rest only when the caller says so.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from lipsync_lang.errors import PackError, refuse_other
from lipsync_lang.packs.finding import Paths, located
from lipsync_lang.performing.label_reader import Unknown
from lipsync_lang.performing.performer import Performer
from lipsync_lang.resolver.compiled import Report
from lipsync_lang.resolver.settings import motion_with

Gaps = Literal["error", "rest"]
"""Ways to treat bigrams that nothing answers."""


def resolve(  # noqa: PLR0913 two names, and what a call may change
    language: str | Path,
    character: str | Path,
    *,
    paths: Paths = (),
    gaps: Gaps = "error",
    unknown: Unknown = "error",
    motion: Mapping[str, object] | str | None = None,
    cache: bool = True,
) -> Performer:
    """Compose a language with a character.

    Parameters
    ----------
    language : a language pack's name, tag, alias or file; ENGINE:CODE for one without a pack
    character : a character's name or file, or a pose set's for its bare self
    paths : a folder to search for packs before all others, or several
    gaps : what becomes of bigrams that nothing answers: an `error`, or `rest`
    unknown : what becomes of labels that no notation maps: an `error`, `rest`, or, of IPA, the
        `nearest` by their features
    motion : a preset's name, or settings of `Motion` to change
    cache : whether a compiled pair may be taken from, and put into, the cache

    Raises
    ------
    PackError
        A pack is missing or unsound; the message holds every fault found.
    LipsyncError
        An argument is none of its choices, or a motion setting is unknown.

    Examples
    --------
    >>> ll.resolve("english", "facefx", motion={"speed_limit": 8}).motion.speed_limit
    8.0
    """
    from lipsync_lang.resolver import cache as store

    refuse_other("gaps", gaps, Gaps)
    refuse_other("unknown", unknown, Unknown)
    (language, character), folders = located(paths, language=language, character=character)
    compiled = store.load(language, character, folders) if cache else None
    if compiled is None:
        from lipsync_lang.packs.library import Library
        from lipsync_lang.resolver.compile import compile_pair

        library = Library(folders)
        compiled = compile_pair(library, language, character)
        if cache:
            store.save(compiled, language, character, library)
    if compiled.report.gaps and gaps != "rest":
        raise PackError(_gap_message(compiled.report))
    return Performer(compiled, motion_with(compiled.motion, motion), unknown, folders)


def _gap_message(report: Report) -> str:
    shown = ", ".join(report.gaps[:12]) + (", ..." if len(report.gaps) > 12 else "")  # noqa: PLR2004
    return (
        f"{report.character} has nothing for {len(report.gaps)} bigrams of {report.language}: "
        f"{shown}. Give {report.poseset} targets for their phonemes, "
        "or ask for gaps at rest (`gaps='rest'`)"
    )
