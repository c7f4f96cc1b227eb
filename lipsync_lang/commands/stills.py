"""The command that draws pictures of a line, with the same camera for all lines of a model."""

import sys
from argparse import Namespace
from dataclasses import replace

from lipsync_lang.commands.output import SOUND, tell_written
from lipsync_lang.commands.performing import perform_line, performer_for, schedule_for
from lipsync_lang.errors import LipsyncError


def stills(options: Namespace) -> int:
    """Draw the model at given times, to a sheet."""
    from lipsync_lang.files import write_all
    from lipsync_lang.render.sheet import moments

    seconds = _seconds(options.at)
    performer = performer_for(options)
    animation = perform_line(options, performer, schedule_for(options, performer))
    shown = performer.rigged(animation)
    if options.model is not None:
        shown = replace(shown, model=options.model)
    write_all({options.output: lambda out: moments(shown, seconds, out, close=options.close)})
    tell_written(options.output)
    for remark in animation.schedule.remarks:
        print(remark, file=sys.stderr)
    return SOUND


def _seconds(stated: str) -> list[float]:
    """Parse times such as ``0.5,0.7``."""
    try:
        return [float(one) for one in stated.split(",")]
    except ValueError:
        raise LipsyncError(
            f"--at {stated}: write seconds separated by commas (--at 0.5,0.7)"
        ) from None
