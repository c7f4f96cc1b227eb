"""Settings of motion as pose sets, characters and projects state them."""

from typing import Annotated, Literal

from pydantic import Field

from lipsync_lang.packs.models.fields import Short, Strict
from lipsync_lang.pipeline.motion import LEAST_SPEED

UpToTen = Annotated[float, Field(ge=0, le=10)]
"""Seconds; more are milliseconds by mistake."""


class MotionFields(Strict):
    """Settings for joining, smoothing and limiting curves; unstated ones have their defaults."""

    preset: Literal["default", "paper"] | None = None
    """A named set of values; the other fields override it."""
    stitch: Literal["max", "crossfade"] | None = None
    """The method of joining overlapping bigrams."""
    warp: Literal["anchored", "linear"] | None = None
    """The method of fitting a bigram to the times of its two phonemes."""
    smooth: Literal["closing", "chord", "none"] | None = None
    """The method of filling valleys between peaks."""
    window: UpToTen | None = None
    """Width of a valley in seconds; narrower valleys are filled."""
    anticipate: Annotated[float, Field(ge=0, le=4)] | None = None
    """Factor for the `anticipate` of poses."""
    speed_limit: Annotated[float, Field(ge=LEAST_SPEED)] | None = None
    """Highest speed of a pose, in weight per second."""
    silence_reach: UpToTen | None = None
    """Seconds at either end of a pause in which the mouth still moves."""
    ends: Literal["rest", "cut"] | None = None
    """`rest` puts silence before the first sound and after the last; `cut` does not."""
    sound_reach: Annotated[float, Field(ge=0.05)] | None = None
    """Seconds of a sound in which the mouth moves; the middle of a longer one is held."""
    contacts: Literal["hold", "free"] | None = None
    """`hold` makes contacts reach their floors and ceilings; `free` does not."""
    limit: Literal["before", "after"] | None = None
    """The place of the speed limit: before or after the constraints."""
    thresholds: Literal["own", "paper"] | None = None
    """The thresholds in use: the pairs' own, or those under `paper`."""
    softness: Annotated[float, Field(ge=0, le=4)] | None = None
    """Factor for the seconds over which poses are rounded off."""
    stress: Annotated[float, Field(ge=0, le=4)] | None = None
    """Factor for the effect of stress on vowels."""
    loudness: Annotated[float, Field(ge=0, le=2)] | None = None
    """Factor for the effect of loudness, where there is sound."""
    reference_level: Annotated[float, Field(ge=-90, le=0)] | None = None
    """Level of ordinary speech in recordings, in dBFS."""
    hold: UpToTen | None = None
    """Least seconds of each pose, with one pose shown at a time; at 0 poses blend."""


OrPreset = Short(
    lambda value: {"preset": value} if isinstance(value, str) else value,
    forms=lambda full: [full, {"type": "string"}],
)
"""Accepts a preset's name alone as motion settings."""
