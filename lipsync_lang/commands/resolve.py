"""The command that shows the origin of the data of a pair."""

from argparse import Namespace
from dataclasses import asdict

from lipsync_lang.commands.output import FAULTS, SOUND, as_json
from lipsync_lang.commands.registry import handler


@handler(
    "resolve",
    "show the layer of each part of a language-character pair, and its gaps",
    "resolve -l english -c facefx",
)
def resolve(options: Namespace) -> int:
    """Print a resolver's report; gaps are faults."""
    from lipsync_lang.resolver.cache import load_report

    pair = options.language, options.character
    report = load_report(*pair, options.path)
    if report is None:  # a performer needs many imports more
        from lipsync_lang.performing.resolving import resolve as resolve_pair

        report = resolve_pair(*pair, paths=options.path, gaps="rest").report
    print(as_json(asdict(report)) if options.json else report)
    return FAULTS if report.gaps else SOUND
