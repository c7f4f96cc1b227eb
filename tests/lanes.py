"""The two lanes of tests, and the sizes of sweeps in each.

A test is in the quick lane (`make test`) unless it is marked `full`. Mark it where it takes more
than a second of CPU, and either repeats for other data what a quick test holds already, or starts
programs that are not ours (pip, a browser, an engine). Of every sweep, some parameters stay quick.
`make test-all` runs both lanes, and the property tests once more with the larger profile.
"""

import os
from collections.abc import Iterable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES

# A worker has one processor: more threads in it wait for each other, up to ten times as long.
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

full = pytest.mark.full

needs_espeak = pytest.mark.skipif(
    find_spec("espeakng_loader") is None, reason="needs espeakng_loader"
)

needs_plug_ins = pytest.mark.skipif(
    find_spec("lipsync_lang.plugins") is None, reason="the wing of plug-ins was removed"
)


def skip_if_its_reader_was_removed(g2p: Any) -> None:
    """Skip a test of a language whose text a plug-in reads or respells, if they were removed."""
    ours = g2p is None or (g2p.engine in G2P_ENGINES.built_in() and not g2p.respell)
    if find_spec("lipsync_lang.plugins") is None and not ours:
        pytest.skip("the wing of plug-ins was removed, which reads its text")


def of_plug_in(module: str, name: str) -> Any:
    """Return what a module of the tests of plug-ins has; an empty dict if they were removed."""
    return getattr(import_module(module), name) if find_spec("lipsync_lang.plugins") else {}


settings.register_profile(
    "quick",
    settings.get_profile("default"),
    deadline=None,
    derandomize=bool(os.environ.get("CI")),  # a change lands by its own merits, not by chance
    print_blob=True,
    max_examples=8,
    suppress_health_check=[
        HealthCheck.too_slow,
        HealthCheck.data_too_large,
        HealthCheck.function_scoped_fixture,
    ],
)
settings.register_profile("full", settings.get_profile("quick"), max_examples=60)
settings.load_profile("quick")


def swept(values: Iterable[Any], quick: int | Iterable[Any] = 1) -> list[Any]:
    """Return the parameters of a sweep; only the quick ones are in the quick lane.

    Parameters
    ----------
    values : what is swept over; tuples where several arguments are
    quick : so many of the first stay in the quick lane, or exactly these
    """
    every = list(values)
    assert every, "a sweep over nothing passes"
    stay = every[:quick] if isinstance(quick, int) else list(quick)
    assert stay, "some of every sweep is quick"
    assert all(value in every for value in stay), "not in the sweep"
    return [value if value in stay else _in_full(value) for value in every]


def _in_full(value: Any) -> Any:
    """Return a parameter of the full lane; a tuple holds one value for each argument."""
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=full)


def costly() -> settings:
    """Return settings for a property with slow examples: a quarter as many."""
    return settings(max_examples=settings().max_examples // 4)
