"""Faces that lines share: the data of a character's model, once beside all its GLB files."""

import posixpath
from collections.abc import Iterable, Mapping
from pathlib import Path

from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.files.writing import atomic
from lipsync_lang.faces.rigs.container import binary_of
from lipsync_lang.faces.rigs.model import known_model
from lipsync_lang.production.builds.needs import PairNeeds
from lipsync_lang.production.builds.planned_line import PlannedLine

FACE_SUFFIX = ".face.bin"

GLB = "glb"
"""Writer of the files that share a face."""

MODEL_DIGEST_CHARS = 8

Pairs = Mapping[tuple[str, str], PairNeeds]
"""Resolved pairs by language and character."""


def face_file(character: str, pair: PairNeeds) -> str:
    """Return the name of the file with the data of a character's model; another has another."""
    return f"{character}-{(pair.model_digest or '')[:MODEL_DIGEST_CHARS]}{FACE_SUFFIX}"


def write_faces(folder: Path, lines: Iterable[PlannedLine], pairs: Pairs) -> None:
    """Write the data of models beside the GLB files of lines, where they are not there."""
    models: dict[str, Path | None] = {}
    for line in lines:
        pair = pairs[line.language, line.character]
        places = {posixpath.dirname(path) for name, path in line.outputs if name == GLB}
        for place in places:
            path = posixpath.join(place, face_file(line.character, pair))
            models[path] = pair.performer.model
    for path, file in models.items():
        if file is None:
            continue  # the writer refuses the line
        model, target = known_model(file, bones=True), folder / path
        content = binary_of(model.path, model.document, model.chunks)
        refuse_outside(target, folder)
        if not target.is_file() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            with atomic(target) as out:
                out.write(content)
