"""Expressions on top of speech: the sum of a smile and a spoken line.

Weights add up, and speech takes precedence: an expression fills the remaining room.

- A contact takes precedence. While lips or teeth touch, an expression adds nothing to a pose that
  the contact keeps low; before and after, it fades with the weights that make the contact.
- A constraint takes precedence. An expression adds no more to a pose than its pairs allow.
- A shape that speech does not move has the weight of the expression, and of a gesture.

Weights of speech are never lowered, so its contacts and constraints still hold. While an expression
fades, speed and acceleration may exceed the limits of the motion.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import spelled
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.performing.delivery import DialLevels, timed
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.pipeline.tables import Tables


def with_expression(animation: Animation, tables: Tables, expression: DialLevels) -> Animation:
    """Return an animation with an expression added; see `Performer.with_expression`.

    The tables have the contacts and constraints that the animation keeps. Columns after their poses
    are those of gestures, and of other expressions.
    """
    wanted = {
        spelled(name, animation.poses): timed("expression", name, level).at(animation.times)
        for name, level in expression.items()
    }
    weights = np.ascontiguousarray(animation.weights.T)
    spoken = weights[: len(tables.priority)]
    # (T,) degree of each contact, 1 if it raises no pose. It may lose GIVEN to the softening,
    # and is closed all the same
    closed = [
        (spoken[one.raised].T / (one.floor[one.raised] - GIVEN)).clip(0, 1).min(1, initial=1.0)
        for one in tables.contacts
    ]
    # a list, since the loop takes names out of `wanted`
    for name in [name for name in wanted if name in animation.poses]:
        pose = animation.poses.index(name)
        if pose < len(spoken):
            spoken[pose] += _added(wanted.pop(name), pose, spoken, tables, closed)
        else:
            most = 1.0 if animation.columns[pose].node is None else np.inf  # degrees of a bone
            weights[pose] = np.minimum(weights[pose] + wanted.pop(name), most)
    rows = np.vstack([weights, *wanted.values()])
    channels = (*animation.columns, *map(Channel, wanted))
    return replace(
        animation,
        poses=(*animation.poses, *wanted),
        weights=np.ascontiguousarray(rows.T),
        channels=channels,
    )


def _added(
    wanted: Floats, pose: int, weights: Floats, tables: Tables, closed: Sequence[Floats]
) -> Floats:
    """Return the share of an expression for a pose within contacts and constraints: (T,)."""
    added = np.minimum(wanted, 1 - weights[pose])
    for contact, made in zip(tables.contacts, closed, strict=True):
        if contact.ceiling[pose] < 1:
            added = added * (1 - made)
    for low, high, threshold in tables.caps:
        if pose in (low, high):
            added = np.minimum(added, threshold - weights[low] - weights[high])
    for low, other in tables.at_most:
        if pose == low:
            added = np.minimum(added, weights[other] - weights[pose])
    return np.maximum(added, 0.0)
