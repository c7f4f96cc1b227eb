"""The command that draws pictures of a line, with the same camera for all lines of a model."""

from argparse import Namespace
from dataclasses import replace

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files import write_all
from lipsync_lang.commands.output import SOUND, tell_all, tell_written
from lipsync_lang.commands.performing import perform_line, performer_for, schedule_for
from lipsync_lang.commands.registry import handler


@handler(
    "stills",
    "draw the model at given times, always from the same camera",
    'stills "Hello, world" -l english -c facefx --at 0.12,0.42 --close -o hello.png',
)
def stills(options: Namespace) -> int:
    """Draw the model at given times, to a sheet."""
    from lipsync_lang.render.sheet import moments

    try:
        seconds = [float(one) for one in options.at.split(",")]
    except ValueError:
        what = f"--at {options.at}: write seconds separated by commas (--at 0.5,0.7)"
        raise LipsyncError(what) from None
    performer = performer_for(options)
    animation = perform_line(options, performer, schedule_for(options, performer))
    shown = performer.rigged(animation)
    if options.model is not None:
        shown = replace(shown, model=options.model)
    write_all({options.output: lambda out: moments(shown, seconds, out, close=options.close)})
    tell_written(options.output)
    tell_all(animation.schedule.remarks)
    return SOUND
