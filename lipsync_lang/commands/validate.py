"""The command that lists the faults of packs."""

import sys
from argparse import Namespace
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import count
from lipsync_lang.commands.output import FAULTS, SOUND, as_json, working
from lipsync_lang.commands.registry import handler
from lipsync_lang.packs.project import FILE, find_project

if TYPE_CHECKING:
    from lipsync_lang.packs.yaml.faults import Fault


@handler(
    "validate",
    "list every fault of every pack found, or of the files given",
    "validate languages/finnish.yaml",
)
def validate(options: Namespace) -> int:
    """Print every fault; warnings alone leave the packs sound."""
    from lipsync_lang.packs.finding import PACK_SUFFIXES
    from lipsync_lang.production.builds.project_build import file_faults

    files = [one for one in options.paths if one.is_file() and one.suffix not in PACK_SUFFIXES]
    packs = [one for one in options.paths if one not in files]
    faults = file_faults(files) if files else []
    if packs or not files:
        faults = sorted({*faults, *_pack_faults(options, packs)})
    if options.json:
        print(as_json([fault.to_dict() for fault in faults]))
    else:
        for fault in faults:
            print(fault)
    real = sum(fault.severity == "fault" for fault in faults)
    warned = count(len(faults) - real, "warning")
    print(f"{count(real, 'fault')}, {warned}", file=sys.stderr)
    return FAULTS if real or (options.strict and faults) else SOUND


def _pack_faults(options: Namespace, paths: list[Path]) -> "list[Fault]":
    """Return the faults of packs, of the tests in them, and of projects."""
    from lipsync_lang.authoring.trial import Trial, doubts, languages_in, try_out, unheard
    from lipsync_lang.packs.checking.validate import validate as find_faults
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.yaml.faults import PackFaults
    from lipsync_lang.packs.yaml.pack_files import shown
    from lipsync_lang.production.builds.project_build import planning_faults

    library = Library(options.path)
    faults = find_faults(library, paths or None)
    found = set(faults)
    with suppress(PackFaults):  # of the common phonemes: they are found already
        silence = library.common().model.silence
        for pack in languages_in(library, paths):
            with working(f"trying {pack.model.name}"):
                tried = Trial(pack) if options.no_tests else try_out(library, pack)
                found.update(tried.faults(silence), doubts(library, pack), unheard(library, pack))
    faults = sorted(found)
    for project in _projects(paths):
        # A faulty project cannot be planned, and would report the same faults again.
        if not any(fault.file == shown(project) and fault.severity == "fault" for fault in faults):
            with working("reading the script"):
                # A set, because planning finds some faults of the project's file again.
                faults = sorted({*faults, *planning_faults(project, options.path)})
    return faults


def _projects(paths: list[Path]) -> list[Path]:
    """Return the project files among the given files and folders, or that of this folder."""
    if not paths:
        found = find_project()
        return [] if found is None else [found]
    files = (path / FILE if path.is_dir() else path for path in paths)
    return [path.absolute() for path in files if path.name == FILE and path.is_file()]
