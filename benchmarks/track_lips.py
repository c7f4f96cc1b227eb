"""Track the lips of a filmed face: aperture and width of the mouth in each frame, as .npz.

    PYTHON benchmarks/track_lips.py FILM OUT.npz [MODEL.task]

PYTHON is an environment with `mediapipe` 0.10.14, whose wheel holds the tracker's model. Distances
are shares of the distance between the outer corners of the eyes, so that the size of the face does
not matter; they are taken in three dimensions, so that a turned head matters little. With MODEL
(`face_landmarker.task`), the ARKit scores of each frame are stored too. Frames without a face are
NaN.
"""

import sys
from collections.abc import Iterator
from typing import Any

import cv2
import mediapipe as mp
import numpy as np

UPPER, LOWER, CORNERS, EYES = 13, 14, (61, 291), (33, 263)
"""Landmarks of the face mesh: inner edges of the lips, corners of the mouth and of the eyes."""

Row = tuple[tuple[float, float], dict[str, float]]
"""Aperture and width of the mouth, and ARKit scores by name."""


def frames(film: str) -> Iterator[np.ndarray]:
    """Yield the (H, W, 3) RGB frames of a film."""
    video = cv2.VideoCapture(film)
    while True:
        found, picture = video.read()
        if not found:
            return
        yield cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)


def lips(landmarks: Any, shape: tuple[int, ...]) -> tuple[float, float]:
    """Return aperture and width of the mouth of one frame."""
    height, width = shape[:2]
    # a landmark's depth has the scale of its x
    place = np.array([[one.x * width, one.y * height, one.z * width] for one in landmarks])
    eyes = np.linalg.norm(place[EYES[0]] - place[EYES[1]])
    aperture = np.linalg.norm(place[UPPER] - place[LOWER])
    return aperture / eyes, np.linalg.norm(place[CORNERS[0]] - place[CORNERS[1]]) / eyes


def mesh(film: str) -> Iterator[Row]:
    """Yield the lips of each frame by the model of the wheel; it knows no ARKit scores."""
    # each frame by itself: the tracker of a film smooths, and would hide contacts
    options = {"static_image_mode": True, "max_num_faces": 1, "refine_landmarks": True}
    with mp.solutions.face_mesh.FaceMesh(**options) as tracker:
        for picture in frames(film):
            found = tracker.process(picture).multi_face_landmarks
            yield lips(found[0].landmark, picture.shape) if found else (np.nan, np.nan), {}


def scored(film: str, model: str) -> Iterator[Row]:
    """Yield the lips and the ARKit scores of each frame by a model of `FaceLandmarker`."""
    vision = mp.tasks.vision
    options = vision.FaceLandmarkerOptions(
        mp.tasks.BaseOptions(model_asset_path=model), output_face_blendshapes=True
    )
    with vision.FaceLandmarker.create_from_options(options) as tracker:
        for picture in frames(film):
            found = tracker.detect(mp.Image(image_format=mp.ImageFormat.SRGB, data=picture))
            if not found.face_landmarks:
                yield (np.nan, np.nan), {}
                continue
            scores = {one.category_name: one.score for one in found.face_blendshapes[0]}
            yield lips(found.face_landmarks[0], picture.shape), scores


def main(film: str, out: str, model: str | None = None) -> None:
    """Track a film and store what was seen."""
    rows = list(scored(film, model) if model else mesh(film))
    names = sorted({name for _, scores in rows for name in scores})
    np.savez(
        out,
        fps=cv2.VideoCapture(film).get(cv2.CAP_PROP_FPS),
        lips=np.array([row for row, _ in rows], float).reshape(-1, 2),
        names=np.array(names, str),
        scores=np.array([[scores.get(name, np.nan) for name in names] for _, scores in rows]),
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
