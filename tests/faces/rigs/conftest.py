"""Fixtures of the tests of rigs."""

import numpy as np
import pytest
from glb_files import POSES, model_of

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation


@pytest.fixture
def put(tmp_path):
    """Write a model, as bytes or as a document, and return its path."""

    def written(content, name="model.glb"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else model_of(content))
        return path

    return written


@pytest.fixture
def animate(put):
    """Return an animation of noise on a model."""

    def animated(content, columns=POSES, frames=20, first=-0.25, **rest):
        named = tuple(c if isinstance(c, str) else c.name for c in columns)
        channels = () if named == tuple(columns) else tuple(columns)
        weights = np.random.default_rng(0).random((frames, len(named)))
        times = first + np.arange(frames) / 60
        schedule = rest.pop("schedule", ll.Schedule(("P",), (0, 0.1)))
        path = content if hasattr(content, "suffix") else put(content)
        rest = {"channels": channels, "model": path} | rest
        return Animation(times, named, weights, 60, schedule, **rest)

    return animated
