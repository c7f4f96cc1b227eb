"""Extras that a project needs: for its languages, its script and its outputs."""

from collections.abc import Iterable
from pathlib import Path

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.extras import install_line
from lipsync_lang.packs.checking.voices import check_voices
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Project
from lipsync_lang.production.builds.output_paths import writer_of
from lipsync_lang.production.builds.planned_line import PlannedLine
from lipsync_lang.production.builds.script_faults import ScriptFaults
from lipsync_lang.resolver.language_tables import manner_of
from lipsync_lang.sound.speech.needed_extras import engines_of, missing_for, missing_words


def extras_of_project(
    project: Project,
    library: Library,
    lines: Iterable[PlannedLine] | None = None,
    tts: str | None = None,
) -> dict[str, list[str]]:
    """Map languages and files of a project to what they need, for `missing_for`.

    Parameters
    ----------
    lines : the lines to make; None if they are unknown, so that any language may be spoken
    tts : a speech engine in place of the languages'
    """
    needed = {stated: [Path(stated).suffix.lower()] for stated in project.lines}
    for stated in project.outputs:
        try:
            needed[stated] = [writer_of(stated)[0]]
        except OutputError:
            continue  # another check refuses it
    heard: dict[str, set[bool]] = {}
    if lines is None:
        names = project.languages or ([project.language] if project.language else [])
        heard = {name: {False, bool(project.audio)} for name in names}
    for line in lines or ():
        if line.timings is None:
            heard.setdefault(line.language, set()).add(line.audio is not None)
    common = library.common().model
    for name, ways in heard.items():
        manner = manner_of(library.language(name), common)
        needed[name] = [*engines_of(manner, spoken=False in ways, heard=True in ways, tts=tts)]
    return needed


def check_installed(
    faults: ScriptFaults,
    project: Project,
    library: Library,
    lines: Iterable[PlannedLine] | None,
    tts: str | None,
) -> None:
    """Add one fault for all that a project needs and is not installed, and those of its voices."""
    needed = extras_of_project(project, library, lines, tts)
    if missing := missing_for(needed):
        what, hint = missing_words(missing), f"install them: {install_line(*missing)}"
        faults.state(("languages",), "P406", what, hint)
    # A look-up of a name that is no language reads the head of every pack.
    named = needed.keys() - {*project.lines, *project.outputs}
    found = [name for name in sorted(named) if library.lookup("language", name)]
    faults.stated += check_voices(map(library.language, found))
