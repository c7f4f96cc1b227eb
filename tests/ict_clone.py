"""A clone of ICT-FaceKit as its repository has it, written from the arrays in ../shared/data."""

import gzip
import os
from pathlib import Path

import numpy as np
import pytest
from places import ROOT

DATA = Path(os.environ.get("LIPSYNC_LANG_TEST_DATA") or ROOT.parent / "shared" / "data") / "head"


def write_clone(folder, identities=3):
    """Write the meshes of the model; the test is skipped without the data."""
    if not DATA.is_dir():
        pytest.skip(f"needs the face model in {DATA}")
    home = folder / "FaceXModel"
    home.mkdir(parents=True)
    neutral = gzip.decompress((DATA / "ict/generic_neutral_mesh.obj.gz").read_bytes())
    (home / "generic_neutral_mesh.obj").write_bytes(neutral)
    points = np.load(DATA / "ict/ict_neutral.npz")["verts"].astype(float)
    shapes = np.load(DATA / "ict/ict_expressions.npz")
    starts = shapes["offsets"]
    for name, first, last in zip(shapes["names"], starts, starts[1:], strict=False):
        moved = points.copy()
        moved[shapes["idx"][first:last]] += shapes["val"][first:last] * float(shapes["quantum"])
        _write(home / f"{name}.obj", moved)
    modes = np.load(DATA / "ict/ict_identity40.npz")
    for number in range(identities):
        _write(
            home / f"identity{number:03}.obj",
            points + modes["modes"][number] * float(modes["quantum"]),
        )
    return folder


def hair_obj(path):
    """Write the hair that was fitted to the model."""
    hair = np.load(DATA / "hair/hair_short01_fitted_to_ict.npz")
    faces = "".join("f {} {} {}\n".format(*row) for row in hair["tris"] + 1)
    path.write_text("".join("v {} {} {}\n".format(*row) for row in hair["verts"]) + faces)
    return path


def _write(path, points):
    path.write_text("".join(f"v {x:.6g} {y:.6g} {z:.6g}\n" for x, y, z in points.tolist()))
