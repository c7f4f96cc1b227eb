"""Damaged models give an animation or a message, never a traceback."""

from copy import deepcopy

import numpy as np
import pytest
from glb_files import JAW, SLIDE, model_of, rich, save, tracks
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import ModelError, OutputError
from lipsync_lang.faces.rigs.channel import Channel

ANYTHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-3, 5)
    | st.sampled_from([2**40, 10**400, 0.5, 1e300, -1e-300, "", "open", "x", "data:,", "é"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)


def places_in(value, path=()):
    """Yield the path of every value in a document."""
    if path:
        yield path
    rows = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in rows if isinstance(value, (dict, list)) else ():
        if isinstance(inner, (dict, list)):
            yield from places_in(inner, (*path, key))
        else:
            yield (*path, key)


RICH = rich()
RICH["nodes"][2]["translation"] = [0, 0, 1]
RICH["nodes"].append({"name": "Neck", "matrix": np.eye(4).ravel().tolist()})
PLACES = list(places_in(RICH))
ALL = (*JAW, *SLIDE, Channel("neck", node="Neck", rotation=(0, 0, 1)))


def survives(content, folder):
    """Write onto a model; either this works, or it raises an error for the user."""
    path = folder / "model.glb"
    path.write_bytes(content)
    weights = np.zeros((2, len(ALL)))
    schedule = ll.Schedule(("P",), (0, 0.1))
    named = tuple(channel.name for channel in ALL)
    animation = Animation(np.arange(2.0), named, weights, 1, schedule, channels=ALL, model=path)
    try:
        tracks(save(animation))
    except (ModelError, OutputError) as error:
        told = str(error)
    else:
        return
    assert told.startswith(str(path))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("models")


@given(st.data())
def test_no_value_in_a_document_is_trusted(folder, data):
    document = deepcopy(RICH)
    for _ in range(data.draw(st.integers(1, 3))):
        *way, last = data.draw(st.sampled_from(PLACES))
        holder = document
        try:
            for key in way:
                holder = holder[key]
            holder[last]
        except (TypeError, LookupError):
            continue  # an earlier change took the place away
        if data.draw(st.booleans()) or not isinstance(holder, (dict, list)):
            if isinstance(holder, (dict, list)):
                holder[last] = data.draw(ANYTHING)
        else:
            del holder[last]
    survives(model_of(document), folder)


@given(st.data())
def test_no_byte_of_a_file_is_trusted(folder, data):
    content = bytearray(model_of(RICH))
    for _ in range(data.draw(st.integers(1, 4))):
        low = data.draw(st.sampled_from([20, len(content)]))
        content[data.draw(st.integers(0, low - 1))] = data.draw(st.integers(0, 255))
    survives(bytes(content[: data.draw(st.sampled_from([None, -1, 20, 300]))]), folder)
