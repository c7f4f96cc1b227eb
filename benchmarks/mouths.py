"""Compare mouths on meshes with filmed lips: how far our heads open, and how wide they are.

    python benchmarks/mouths.py FOLDER [-c HEAD ...] [-l english] [--all] [--json FILE]

FOLDER holds `NAME_texts.tsv` (clip, text), `NAME_lips.tsv.gz` (clip, second, inner_gap, width, in
any unit) and `NAME_sound/CLIP.ogg`. Each text is aligned with its sound, each HEAD (a model, or a
character with one) performs it, and its shapes are measured on its mesh, in widths of the mouth.
No picture is drawn, so this is quick. `face_on.py` tracks rendered films.

The mouths of `languages/common.yaml` were learnt from 170 sentences of the GRID speaker s1. The
sentences judged are the twenty others: the first twenty of every ninth clip. `--all` judges every
clip of a folder that nothing was learnt from.

aperture r, width r   Pearson's r over the frames of speech, the mean of all clips
range                 our standard deviation divided by that of the film
"""

import argparse
import csv
import gzip
import sys
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import json_figures
import numpy as np

import lipsync_lang as ll
from lipsync_lang.faces.rigs.model import known_model
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.solving import pose_gains

LATE_SECONDS = 0.02
"""The lips of a frame are those of this many seconds later in the sound."""

EVERY, JUDGED = 9, 20
"""The clips that mouths were not learnt from."""

HEADS = ("facefx",)


class Head(NamedTuple):
    """A performer, and what its poses do to the measures of the mouth: (4, P)."""

    performer: ll.Performer
    gains: np.ndarray

    @classmethod
    def of(cls, name: str, language: str) -> "Head":
        """Read a head; end with a sentence if it has no model that can be measured."""
        performer = ll.resolve(language, name)
        compiled = performer.compiled
        poseset = Library().poseset(compiled.poseset).model.having(performer.poses)
        if compiled.model is None:
            sys.exit(f"{name} has no model; name one, such as -c head.glb")
        gains = pose_gains(poseset, known_model(Path(compiled.model)), compiled.rig)
        if gains is None:
            sys.exit(f"{name}: the mouth of {compiled.model} cannot be measured")
        return cls(performer, gains)

    def lips(self, animation: ll.Animation) -> np.ndarray:
        """Return aperture and width of each frame: (2, T)."""
        count = self.gains.shape[1]
        found = (self.gains @ animation.weights[:, :count].T)[:2]
        found[0] = np.maximum(0.0, found[0])
        return found


def filmed(folder: Path) -> dict[str, tuple[str, Path, np.ndarray]]:
    """Return text, sound and (T, 3) seconds, aperture and width of each clip."""
    found = {}
    for texts in sorted(folder.glob("*_texts.tsv")):
        name = texts.name.removesuffix("_texts.tsv")
        rows = defaultdict(list)
        with gzip.open(folder / f"{name}_lips.tsv.gz", "rt", encoding="utf-8") as stream:
            for row in csv.DictReader(stream, delimiter="\t"):
                values = (row[key] for key in ("second", "inner_gap", "width"))
                rows[row["clip"]].append([float(value or "nan") for value in values])
        width = np.nanmedian([np.nanmedian(np.array(one)[:, 2]) for one in rows.values()])
        with texts.open(encoding="utf-8") as stream:
            for row in csv.DictReader(stream, delimiter="\t"):
                lips = np.array(rows[row["clip"]]) / (1.0, width, width) - (0, 0, 1)
                sound = folder / f"{name}_sound" / f"{row['clip']}.ogg"
                found[row["clip"]] = row["text"], sound, lips
    return found


def judge(head: Head, clips: list[tuple[ll.Schedule, np.ndarray]]) -> dict[str, float]:
    """Return r and range of aperture and width over clips."""
    rs, ours, theirs = [], [], []
    for schedule, lips in clips:
        animation = head.performer.perform(schedule, 100)
        times = lips[:, 0] + LATE_SECONDS
        first, last = schedule.times[1], schedule.times[-2]
        inside = (times >= first) & (times <= last) & np.isfinite(lips).all(axis=1)
        mine = [np.interp(times[inside], animation.times, one) for one in head.lips(animation)]
        real = lips[inside, 1:].T
        rs.append([np.corrcoef(a, b)[0, 1] for a, b in zip(mine, real, strict=True)])
        ours.append(mine)
        theirs.append(real)
    aperture, width = np.nanmean(rs, axis=0)
    ranges = np.concatenate(ours, axis=1).std(axis=1) / np.concatenate(theirs, axis=1).std(axis=1)
    return {
        "aperture r": float(aperture), "width r": float(width),
        "aperture range": float(ranges[0]), "width range": float(ranges[1]),
    }  # fmt: skip


def main() -> None:
    """Print a row for each head."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-c", "--character", action="append", metavar="HEAD")
    parser.add_argument("-l", "--language", default="english")
    parser.add_argument("--all", action="store_true")
    json_figures.add_option(parser)
    options = parser.parse_args()
    films = filmed(options.folder)
    if not films:
        sys.exit(f"{options.folder} holds no NAME_texts.tsv with tracked lips and sound beside it")
    names = sorted(films)
    names = names if options.all else names[::EVERY][:JUDGED]
    heads = {one: Head.of(one, options.language) for one in options.character or HEADS}
    sounds, texts = [films[n][1] for n in names], [films[n][0] for n in names]
    schedules = [*ll.align(sounds, texts, options.language)]
    clips = [(one, films[n][2]) for one, n in zip(schedules, names, strict=True)]
    rows = []
    print(f"{len(clips)} clips, measured on meshes")
    for name, head in heads.items():
        figures = judge(head, clips)
        told = ", ".join(f"{key} {value:.2f}" for key, value in figures.items())
        print(f"{Path(name).stem} as {head.performer.compiled.poseset}: {told}")
        rows.append({"head": Path(name).stem, **figures})
    json_figures.write_figures(options.json, {"clips": len(clips), "rows": rows})


if __name__ == "__main__":
    main()
