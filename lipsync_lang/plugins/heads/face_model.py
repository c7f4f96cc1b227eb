"""A face model in OBJ files and its recipe: the neutral face, its shapes and its identities.

A recipe is a file of `recipes`: where the files are, what the ranges of faces are, and which files
make a shape. Lengths are those of the model, (V, 3) for its V points.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path

import numpy as np

from lipsync_lang import LipsyncError, ModelError
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.json_object import Json
from lipsync_lang.packs.yaml.events import load_yaml
from lipsync_lang.plugins.heads.obj_files import ObjMesh, obj_comment, obj_mesh, obj_points

LIKELY = 0.7
"""Standard deviation of drawn identities, in those of the model; larger ones look less real."""

NAMED_MISSING_FILES = 3
"""Number of missing files that a message names."""


def read_recipe(name: str) -> Json:
    """Read a recipe by name."""
    text = files(__package__).joinpath("recipes", f"{name}.yaml").read_text("utf-8")
    return load_yaml(text)


@dataclass(frozen=True)
class FaceModel:
    """The files of a face model in a folder, which may be the clone or its folder of meshes."""

    folder: Path
    recipe: Json

    def __post_init__(self) -> None:
        """Check that the files are there; a ModelError names those that are missing."""
        if not self.folder.is_dir():
            raise ModelError(f"{self.folder}: is no folder; get the model: {self.recipe['clone']}")
        names = [self.recipe["neutral"], *(f"{one}.obj" for one in self._files())]
        missing = [name for name in names if not (self.home / name).is_file()]
        if missing:
            few = shortlist(missing, NAMED_MISSING_FILES)
            raise ModelError(f"{self.home}: lacks {few}; get the model: {self.recipe['clone']}")

    @cached_property
    def home(self) -> Path:
        """The folder of the meshes."""
        within = self.folder / self.recipe["folder"]
        return within if within.is_dir() else self.folder

    @cached_property
    def neutral(self) -> ObjMesh:
        """The neutral face."""
        path = self.home / self.recipe["neutral"]
        mesh = obj_mesh(path, self.recipe["points"])
        if (count := mesh.faces[-1] + 1) != self.recipe["faces"]:
            stated = self.recipe["faces"]
            raise ModelError(f"{path}: has {count:,} faces instead of {stated:,}; clone it again")
        return mesh

    @property
    def licence(self) -> str:
        """The licence in the neutral mesh, which goes along with every head."""
        return obj_comment(self.home / self.recipe["neutral"])

    def shapes(self) -> dict[str, Floats]:
        """Read the displacement of each shape."""
        gains = self.recipe["gains"]
        found = {
            name: gains.get(name, 1)
            * sum((self._shift(f"{one}.obj") for one in files), np.zeros(()))
            for name, files in self._sums().items()
        }
        for name, others in self.recipe["corrected"].items():
            found[name] = found[name] + sum(share * found[one] for one, share in others.items())
        return found

    def identity(self, stated: Mapping[int, float], seed: int | None) -> Floats:
        """Add identities by number, in standard deviations; a seed draws all others."""
        paths = sorted(self.home.glob(self.recipe["identities"]))
        weights = dict.fromkeys(range(len(paths)), 0.0)
        if (stated or seed is not None) and not paths:
            what = f"has no {self.recipe['identities']}, so its face cannot change"
            raise ModelError(f"{self.home}: {what}; get the model: {self.recipe['clone']}")
        if seed is not None:
            # Also for stated identities, so that a statement changes none of the others.
            drawn = np.random.default_rng(seed).standard_normal(len(paths)) * LIKELY
            weights |= dict(enumerate(drawn.tolist()))
        unknown = [number for number in stated if number not in weights]
        if unknown:
            raise LipsyncError(
                f"identity {unknown[0]} is unknown: {self.home} has 0 to {len(paths) - 1}"
            )
        found = np.zeros_like(self.neutral.points)
        for number, weight in {**weights, **stated}.items():
            if weight:
                found += weight * self._shift(paths[number].name)
        return found

    def _shift(self, name: str) -> Floats:
        return obj_points(self.home / name, self.recipe["points"]) - self.neutral.points

    def _sums(self) -> dict[str, Sequence[str]]:
        recipe = self.recipe
        sums: dict[str, Sequence[str]] = {one: [one] for one in recipe["alone"]}
        for one in recipe["sided"]:
            sums |= {f"{one}Left": [f"{one}_L"], f"{one}Right": [f"{one}_R"]}
        return dict(sorted({**sums, **recipe["shapes"]}.items()))

    def _files(self) -> list[str]:
        return [one for several in self._sums().values() for one in several]
