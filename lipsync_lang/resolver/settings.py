"""Motion settings by name, from packs, calls and the command line."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, get_args, get_type_hints

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.pipeline.motion import LEAST_SPEED, PRESETS, Motion

RANGES = {
    "speed_limit": (LEAST_SPEED, 1e6),
    "window": (0.0, 10.0),
    "anticipate": (0.0, 4.0),
    "softness": (0.0, 4.0),
    "stress": (0.0, 4.0),
    "loudness": (0.0, 2.0),
    "reference_level": (-90.0, 0.0),
    "silence_reach": (0.0, 10.0),
    "sound_reach": (0.05, 1e6),
    "hold": (0.0, 10.0),
}
"""Range of each numeric setting: weight per second, seconds, a factor, or decibels."""


def motion_with(base: Motion, change: Mapping[str, object] | str | None) -> Motion:
    """Return motion settings changed by a preset's name, by values, or by both."""
    if change is None:
        return base
    settings = {"preset": change} if isinstance(change, str) else dict(change)
    preset = settings.pop("preset", None)
    if preset is not None:
        if preset not in PRESETS:
            hint = did_you_mean(str(preset), PRESETS)
            raise LipsyncError(f"unknown motion preset '{preset}'; {hint}")
        base = PRESETS[str(preset)]
    known = {f.name for f in fields(Motion)}
    changed: dict[str, Any] = {}
    for name, value in settings.items():
        if name not in known:
            raise LipsyncError(f"unknown motion setting '{name}'; {did_you_mean(name, known)}")
        changed[name] = _checked(name, value, getattr(base, name))
    return replace(base, **changed)


def _checked(name: str, value: object, like: object) -> object:
    """Return a motion setting's value in its own type, or raise an error with its range."""
    # numbers have no arguments of type, a `Literal` has its choices
    choices = get_args(get_type_hints(Motion)[name])
    if choices:
        if value not in choices:
            raise LipsyncError(f"motion.{name} is {value!r}; it is one of {', '.join(choices)}")
        return value
    try:
        number = float(value)  # type: ignore[arg-type]  # conversion errors are reported below
    except (TypeError, ValueError):
        number = float("nan")
    least, most = RANGES[name]
    if isinstance(value, bool) or not least <= number <= most:  # refuses nan too
        raise LipsyncError(
            f"motion.{name} is {value!r}; it is a number from {least:g} to {most:g}, as {like}"
        )
    return number
