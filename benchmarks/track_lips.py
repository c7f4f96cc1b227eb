"""Track the lips of a filmed face: aperture and width of the mouth in each frame, as .npz.

    PYTHON benchmarks/track_lips.py FILM OUT.npz

PYTHON is an environment with `mediapipe` 0.10.14, whose wheel holds the tracker's model. Distances
are shares of the distance between the outer corners of the eyes, so that the size of the face does
not matter; they are taken in three dimensions, so that a turned head matters little. Frames without
a face are NaN.
"""

import sys
from collections.abc import Iterator
from typing import Any

import cv2
import mediapipe as mp
import numpy as np

UPPER, LOWER, CORNERS, EYES = 13, 14, (61, 291), (33, 263)
"""Landmarks of the face mesh: inner edges of the lips, corners of the mouth and of the eyes."""


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


def mesh(film: str) -> Iterator[tuple[float, float]]:
    """Yield the lips of each frame by the model of the wheel."""
    # each frame by itself: the tracker of a film smooths, and would hide contacts
    options = {"static_image_mode": True, "max_num_faces": 1, "refine_landmarks": True}
    with mp.solutions.face_mesh.FaceMesh(**options) as tracker:
        for picture in frames(film):
            found = tracker.process(picture).multi_face_landmarks
            yield lips(found[0].landmark, picture.shape) if found else (np.nan, np.nan)


def main(film: str, out: str) -> None:
    """Track a film and store what was seen."""
    rows = np.array([*mesh(film)], float).reshape(-1, 2)
    np.savez(out, fps=cv2.VideoCapture(film).get(cv2.CAP_PROP_FPS), lips=rows)


if __name__ == "__main__":
    main(*sys.argv[1:])
