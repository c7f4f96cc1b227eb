"""The command that measures an animation, performed here or read from a file."""

import sys
from argparse import Namespace
from dataclasses import replace
from operator import methodcaller
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extensions import Extensions
from lipsync_lang.base.files import write_all
from lipsync_lang.commands.output import FAULTS, SOUND, as_json, tell_written
from lipsync_lang.commands.performing import LINE_PAGE, perform_line, performer_for, schedule_for
from lipsync_lang.commands.registry import handler

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.base.json_object import Json
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.reports.quality.figures import Quality

SUFFIXES = {".json": "json", ".xml": "junit", ".html": LINE_PAGE}
"""Format of a file by its suffix; all other files are text."""

FACE_CHECKS: "Extensions[Callable[[Performer], tuple[str, Json]]]" = Extensions(
    "face_checks", "check of a face"
)
"""Checks by plug-ins of a face without a line: functions that return a text, and its data."""


@handler(
    "check",
    "measure the quality of an animation, and compare it with limits",
    'check "Hello, world" -l english -c facefx --baseline',
    more="; without a TEXT, compare a new head with the mouths of the language's sounds",
)
def check(options: Namespace) -> int:
    """Print the figures of an animation; a figure past its limit is a fault."""
    from lipsync_lang.reports.quality.baselines import BASELINES
    from lipsync_lang.reports.quality.check_animation import FORMATS
    from lipsync_lang.reports.quality.check_animation import check as judge

    performer = performer_for(options)
    spoken = any(getattr(options, of) is not None for of in ("text", "schedule", "audio"))
    if FACE_CHECKS and not spoken and options.animation is None:
        return _of_face(options, performer)
    animation, remarks = _animation(options, performer)
    first = str(options.animation) if options.animation else "performed"
    takes = {first: animation}
    for method, make in BASELINES.items() if options.baseline else ():
        plain = make(performer, animation.schedule, options.fps)
        takes[method] = performer.rigged(plain) if options.channels else plain
    limits: dict[str, float] = {}
    for one in options.limits:
        measure, _, number = one.partition("=")
        try:
            limits[measure] = float(number)
        except ValueError:
            what = f"--limit {one}: write NAME=NUMBER (--limit {measure or 'jitter'}=2)"
            raise LipsyncError(what) from None
    told_by = {first: remarks}
    judged = {
        name: judge(take, performer=performer, limits=limits, remarks=told_by.get(name, ()))
        for name, take in takes.items()
    }

    def told(form: str) -> str:
        return _page(performer, takes, judged) if form == LINE_PAGE else FORMATS[form](judged)

    _put(options, told)
    quality = judged[first]
    if options.output or options.format not in (None, "text"):
        names = ", ".join(figure.name for figure in quality.failed)
        print(f"{quality.summary}{f'; missed: {names}' if names else ''}", file=sys.stderr)
    return SOUND if quality.passed else FAULTS


def _put(options: Namespace, told: "Callable[[str], str]") -> None:
    """Print a report in its format, or write it to files."""
    if not options.output:
        print(told(options.format or "text"))
    # All forms are made before any file is opened: an error leaves old reports alone.
    forms = {
        one: options.format or SUFFIXES.get(one.suffix.lower(), "text") for one in options.output
    }
    contents = {path: f"{told(form)}\n".encode() for path, form in forms.items()}
    write_all({path: methodcaller("write", content) for path, content in contents.items()})
    tell_written(*options.output)


def _of_face(options: Namespace, performer: "Performer") -> int:
    """Check the face itself, without a line."""
    found = {name: judge(performer) for name, judge in FACE_CHECKS.items()}
    forms = {"text": "\n".join(text for text, _ in found.values())}
    forms["json"] = as_json({name: data for name, (_, data) in found.items()})
    idle = ("baseline", "channels", "limits", "line", "styles", "dials")

    def told(form: str) -> str:
        if form not in forms or any(getattr(options, name) for name in idle):
            named = ", ".join(f"--{name.removesuffix('s')}" for name in idle)
            raise LipsyncError(f"give a TEXT for pages, JUnit, {named}")
        return forms[form]

    _put(options, told)
    return SOUND


def _page(
    performer: "Performer", takes: "Mapping[str, Animation]", judged: "Mapping[str, Quality]"
) -> str:
    """Return a page of the first take, with the others beside it."""
    from lipsync_lang.animations.animation import ExportSettings
    from lipsync_lang.reports.quality.fitting import on_model
    from lipsync_lang.studio.line_page import line_page

    first, *others = takes
    shown = {name: on_model(take, performer) for name, take in takes.items()}
    export = ExportSettings(against={name: shown[name] for name in others})
    main = replace(shown[first], export=export)
    return line_page(main, performer=performer, qualities={**judged, "": judged[first]})


def _animation(options: Namespace, performer: "Performer") -> "tuple[Animation, tuple[str, ...]]":
    """Perform the line, or read its animation from a file."""
    if options.animation is not None:
        from lipsync_lang.reports.quality.fitting import read_for

        spoken = any(getattr(options, of) is not None for of in ("text", "schedule", "audio"))
        schedule = schedule_for(options, performer) if spoken else None
        return read_for(performer, options.animation, schedule, channels=options.channels)

    animation = perform_line(options, performer, schedule_for(options, performer))
    if options.channels and performer.compiled.rig is None:
        raise LipsyncError(f"{performer.character} has no rig; leave out --channels")
    return (performer.rigged(animation) if options.channels else animation), ()
