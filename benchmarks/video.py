"""Print how fast a model is drawn: frames per second on one core, beside the goal.

python benchmarks/video.py [MODEL [CHARACTER]]
"""

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

import numpy as np

import lipsync_lang as ll
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.staging import staged
from lipsync_lang.render.video import FRAME_PIXELS

GOAL = 15
LABELS = ["HH", "AH", "L", "OW", "W", "ER", "L", "D", "P", "L", "IY", "Z", "B", "AY", "F", "AY"]
HEAD = Path(__file__).resolve().parents[2] / "shared/data/rigs/head_arkit52_oculus15.glb"


def main() -> None:
    """Draw every frame of a line, with processor time counted: others may be at work here."""
    model = Path(sys.argv[1]) if len(sys.argv) > 1 else HEAD
    performer = ll.resolve("english", sys.argv[2] if len(sys.argv) > 2 else "arkit")
    schedule = ll.Schedule(LABELS, np.arange(len(LABELS) + 1) * 0.1, notation="arpabet")
    animation = replace(performer.rigged(performer.perform(schedule, fps=30)), model=model)
    began = time.process_time()
    scene = staged(animation)
    artist = Artist(scene, FRAME_PIXELS)
    print(f"{model.name}: {len(scene.triangles)} triangles, {FRAME_PIXELS} x {FRAME_PIXELS} pixels")
    print(f"making ready      {time.process_time() - began:6.2f} s")
    spent = []
    for number in range(len(animation.times)):
        began = time.process_time()
        artist.draw(number / animation.fps)
        spent.append(time.process_time() - began)
    for what, each in (("median", np.median(spent)), ("undisturbed", np.quantile(spent, 0.1))):
        print(f"{what:17} {1 / each:6.1f} frames/s (goal: {GOAL})")


if __name__ == "__main__":
    main()
