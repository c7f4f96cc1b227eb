"""Commands that validate packs and report the origin of resolved data."""

import sys
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.commands.output import FAULTS, SOUND, as_json, count, working

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library
    from lipsync_lang.packs.yaml.faults import Fault


def resolve(options: Namespace) -> int:
    """Print a resolver's report; gaps are faults."""
    from dataclasses import asdict

    from lipsync_lang.performing.resolving import resolve as resolve_pair

    report = resolve_pair(
        options.language, options.character, paths=options.path, gaps="rest"
    ).report
    print(as_json(asdict(report)) if options.json else report)
    return FAULTS if report.gaps else SOUND


def validate(options: Namespace) -> int:
    """Print every fault; warnings alone leave the packs sound."""
    from lipsync_lang.packs.checking.validate import validate as find_faults
    from lipsync_lang.packs.library import Library

    library = Library(options.path)
    faults = find_faults(library, options.paths or None)
    if not options.no_tests:
        faults = sorted({*faults, *_failing(library, options.paths)})
    if options.json:
        print(as_json([fault.to_dict() for fault in faults]))
    else:
        for fault in faults:
            print(fault)
    real = sum(fault.severity == "fault" for fault in faults)
    warned = count(len(faults) - real, "warning")
    print(f"{count(real, 'fault')}, {warned}", file=sys.stderr)
    return FAULTS if real else SOUND


def _failing(library: "Library", paths: list[Path]) -> Iterator["Fault"]:
    """Run the tests of the selected languages, with progress messages."""
    from lipsync_lang.authoring.trial import doubts, languages_in, try_out

    silence = library.common().model.silence
    for pack in languages_in(library, paths):
        with working(f"trying {pack.model.name}"):
            yield from try_out(library, pack).faults(silence)
            yield from doubts(library, pack)


def schema(options: Namespace) -> int:
    """Print a schema, or the kinds that have one."""
    from lipsync_lang.packs.models.schema import kinds
    from lipsync_lang.packs.models.schema import schema as make_schema

    if options.kind is None:
        print(as_json(kinds()) if options.json else "\n".join(kinds()))
    else:
        print(as_json(make_schema(options.kind)))
    return SOUND
