"""Models as GLB for tests: made of parts, and read back with their animations."""

import json
import struct
from copy import deepcopy
from io import BytesIO

import numpy as np

from lipsync_lang.animations.writers.glb import write_glb
from lipsync_lang.faces.rigs.channel import Channel

JSON_CHUNK, BINARY_CHUNK, OTHER_CHUNK = 0x4E4F534A, 0x004E4942, 0x12345678
SHAPES = ("open", "wide", "Lips_Up")
POSES = ("open", "wide")


# A model of our own, with more in it than we know


def chunk(kind, data):
    padded = data + (b" " if kind == JSON_CHUNK else b"\0") * (-len(data) % 4)
    return struct.pack("<2I", len(padded), kind) + padded


def glb(document, *chunks):
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    body = chunk(JSON_CHUNK, text) + b"".join(chunk(*one) for one in chunks)
    return struct.pack("<4s2I", b"glTF", 2, 12 + len(body)) + body


def mesh(name, shapes, **rest):
    targets = [{"POSITION": 1 + number} for number in range(len(shapes))]
    primitive = {"attributes": {"POSITION": 0}, "indices": 4, "targets": targets}
    row = {"primitives": [primitive], "extras": {"targetNames": list(shapes)}, **rest}
    return row | {"name": name} if name else row


def document_of(*meshes, **rest):
    """Return a document of a triangle with three shapes, and a node for each mesh."""
    points = [[0, 0, 0], [1, 1, 0]]
    view = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
    rows = [view | {"byteOffset": 36 * n, "min": points[0], "max": points[1]} for n in range(4)]
    index = {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}
    names = [one.get("name", f"node {n}") for n, one in enumerate(meshes)]
    return {
        "asset": {"version": "2.0", "generator": "a test", "copyright": "ours"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [{"name": name, "mesh": n} for n, name in enumerate(names)],
        "meshes": list(meshes),
        "accessors": [*rows, index],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 144, "byteStride": 12},
            {"buffer": 0, "byteOffset": 144, "byteLength": 3, "target": 34963},
        ],
        "buffers": [{"byteLength": 147}],
        **rest,
    }


BINARY = np.tile(np.array([0, 0, 0, 1, 0, 0, 0, 1, 0], "<f4"), 4).tobytes() + bytes([0, 1, 2])


def model_of(document, *chunks):
    return glb(document, (BINARY_CHUNK, BINARY), *chunks)


FACE = document_of(mesh("Face", SHAPES), mesh("Teeth", ("open",)))


def rich():
    """Return a document with fields of all kinds, and unknown fields."""
    document = deepcopy(FACE)
    document["meshes"][0] |= {"weights": [0, 0.25, 0.5]}
    document["nodes"] += [
        {"name": "Jaw", "rotation": [0, 0, 0, 1.0], "vendor": {"deep": [1, 2.0, None]}},
        {"name": "Face again", "mesh": 0, "weights": [0, 0.125, 1], "extras": {"é": "\ud800"}},
    ]
    document["animations"] = [
        {
            "name": "hello",
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}],
            "samplers": [{"input": 5, "output": 6}],
        }
    ]
    view = {"bufferView": 0, "componentType": 5126, "count": 1}
    document["accessors"] += [
        view | {"type": "SCALAR", "min": [0], "max": [0]},
        view | {"type": "VEC3"},
    ]
    document |= {
        "extensionsUsed": ["EXT_ours"],
        "extensions": {"EXT_ours": {"é": [1e-05, 1, 1.0, -0.0, True, None]}},
        "vendor": {"top": 12345678901234567890},
        "extras": {"日本": "語"},
    }
    document["bufferViews"][0]["extensions"] = {"EXT_ours": {"buffer": 0}}
    document["buffers"][0]["extras"] = {"kept": True}
    document["asset"]["extras"] = {"kept": True}
    return document


def parts(content):
    """Return the document of a GLB, and its other chunks."""
    magic, version, length = struct.unpack_from("<4s2I", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    found, start = [], 12
    while start < length:
        size, kind = struct.unpack_from("<2I", content, start)
        assert size % 4 == start % 4 == 0
        found.append((kind, content[start + 8 : start + 8 + size]))
        start += 8 + size
    assert found[0][0] == JSON_CHUNK
    return json.loads(found[0][1].decode("utf-8")), found[1:]


def save(animation):
    out = BytesIO()
    write_glb(animation, out)
    return out.getvalue()


def values(document, binary, number):
    row = document["accessors"][number]
    view = document["bufferViews"][row["bufferView"]]
    assert view["buffer"] == 0
    start = view["byteOffset"] + row["byteOffset"]
    assert start % 4 == 0
    wide = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[row["type"]]
    assert row["byteOffset"] + 4 * row["count"] * wide <= view["byteLength"]
    array = np.frombuffer(binary, "<f4", row["count"] * wide, start)
    return array if wide == 1 else array.reshape(-1, wide)


def tracks(content):
    """Return the last animation: its row, times, and {(node, path): values}."""
    document, ((kind, binary), *_) = parts(content)
    assert kind == BINARY_CHUNK
    assert document["buffers"][0]["byteLength"] <= len(binary)
    animation = document["animations"][-1]
    found, inputs, driven = {}, set(), set()
    for one in animation["channels"]:
        sampler = animation["samplers"][one["sampler"]]
        assert sampler["interpolation"] == "LINEAR"
        inputs.add(sampler["input"])
        curve = values(document, binary, sampler["output"])
        target = one["target"]
        assert (target["node"], target["path"]) not in driven
        driven.add((target["node"], target["path"]))
        node = document["nodes"][target["node"]].get("name")
        found[node, target["path"]] = curve
    (shared,) = inputs
    times = values(document, binary, shared)
    row = document["accessors"][shared]
    assert (row["min"], row["max"]) == ([times[0]], [times[-1]])
    shaped = {k: v.reshape(len(times), -1) if k[1] == "weights" else v for k, v in found.items()}
    return animation, times, shaped


JAW = (Channel("open"), Channel("jaw", node="Jaw", rotation=(2, 0, 0)))
SLIDE = (Channel("jaw", node="Jaw", translation=(0, -0.5, 1)),)


def with_jaw(**pose):
    document = deepcopy(FACE)
    document["nodes"].append({"name": "Jaw", **pose})
    document["scenes"][0]["nodes"].append(2)
    return document
