"""Models of one triangle, whose meshes, shapes and bones have names."""

import json
import struct


def glb(path, *shapes, bones=(), extensions=None, **meshes):
    """Write a model: the shapes of one mesh, or of several by name, bones, and extensions."""
    points = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    accessor = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
    named = {**({"head": shapes} if shapes else {}), **meshes}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(points)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)}],
        "accessors": [{**accessor, "min": [0, 0, 0], "max": [1, 1, 0]}],
        "meshes": [_mesh(name, own) for name, own in named.items()],
        "nodes": [
            *({"mesh": number, "name": name} for number, name in enumerate(named)),
            *({"name": name} for name in bones),
        ],
        "scenes": [{"nodes": [*range(len(named) + len(bones))]}],
    }
    if extensions:  # glTF allows neither to be empty
        document |= {"extensions": extensions, "extensionsUsed": [*extensions]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(points), 0x004E4942) + points
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    return path


def _mesh(name, shapes):
    primitive = {"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}] * len(shapes)}
    return {"name": name, "primitives": [primitive], "extras": {"targetNames": shapes}}
