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
95 %, 5 %, SD         percentiles and standard deviation, of the film and of each head

Filmed lips are somewhat ahead of their sound; the program finds by how much, and compares them
there. A table follows: the aperture at the middle of each phoneme in the films, and how much more
each head has there.
"""

import argparse
import csv
import gzip
import sys
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import json_figures
import numpy as np

import lipsync_lang as ll
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.reports.quality.face_columns import SeenMouth, face_of

EVERY, JUDGED = 9, 20
"""The clips that mouths were not learnt from."""

HEADS = ("facefx",)

LEADS = np.arange(-0.1, 0.101, 0.01).round(2)
"""Seconds by which filmed lips may be ahead of their sound."""

LEAST_TIMES = 5
"""Smallest number of a phoneme in the table of errors."""

NAMES = ("head", "poseset")

Clips = list[tuple[ll.Schedule, np.ndarray]]
"""Timed phonemes, and (T, 3) seconds, aperture and width, of each clip."""

Sounds = dict[str, list[tuple[float, float]]]
"""Our aperture at the middle of a phoneme, and that of the film, by its name."""


class Head(NamedTuple):
    """A performer, and the mouth on its mesh."""

    performer: ll.Performer
    seen: SeenMouth

    @classmethod
    def of(cls, name: str, language: str) -> "Head":
        """Read a head; end with a sentence if it has no mouth that can be measured."""
        try:
            performer = ll.resolve(language, name)
        except ll.LipsyncError as error:
            sys.exit(f"{name}: {error}")
        seen = face_of(performer.perform(ll.Schedule(("_",), [0, 1])), performer).seen
        if performer.model is None:
            sys.exit(f"{name} has no model; name one, such as -c head.glb")
        if seen is None:
            sys.exit(f"{name}: the mouth of {performer.model} cannot be measured")
        return cls(performer, seen)

    def lips(self, animation: ll.Animation) -> np.ndarray:
        """Return aperture and width of each frame: (2, T)."""
        count = self.seen.gains.shape[1]
        found = (self.seen.gains @ animation.weights[:, :count].T)[:2]
        found[0] = np.maximum(0.0, found[0])
        return found

    def sounds(self, schedule: ll.Schedule) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of the common phonemes of a line, and their bounds."""
        track = self.performer.track(schedule)
        return track.ids, track.bounds


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


def lead(head: Head, clips: Clips) -> float:
    """Return the seconds by which the lips of the films are ahead of their sound.

    The apertures that sounds have in film make a course of steps, which fits the lips best there.
    """
    found = []
    for ahead in LEADS:
        rs = []
        for schedule, lips in clips:
            ids, bounds = head.sounds(schedule)
            at = np.searchsorted(bounds, lips[:, 0] + ahead, "right") - 1
            inside = (at > 0) & (at < len(ids) - 1)
            steps = np.full(len(at), np.nan)
            steps[inside] = head.seen.apertures[ids[at[inside]]]
            known = np.isfinite(steps) & np.isfinite(lips[:, 1])
            rs.append(np.corrcoef(steps[known], lips[known, 1])[0, 1])
        found.append(np.nanmean(rs))
    return float(LEADS[int(np.argmax(found))])


def spread(lips: np.ndarray) -> dict[str, float]:
    """Return how far lips of (2, T) open and how their width changes."""
    low, high = np.percentile(lips[1], (5, 95))
    return {
        "aperture 95 %": float(np.percentile(lips[0], 95)),
        "width 5 %": float(low), "width 95 %": float(high),
        "aperture SD": float(lips[0].std()), "width SD": float(lips[1].std()),
    }  # fmt: skip


def judge(
    head: Head, clips: Clips, ahead: float
) -> tuple[dict[str, float], dict[str, float], Sounds]:
    """Return figures of a head, those of the films, and the aperture of each phoneme in both."""
    rs, ours, theirs = [], [], []
    sounds: Sounds = defaultdict(list)
    for schedule, lips in clips:
        animation = head.performer.perform(schedule, 100)
        times = lips[:, 0] + ahead
        first, last = schedule.times[1], schedule.times[-2]
        inside = (times >= first) & (times <= last) & np.isfinite(lips).all(axis=1)
        shown = head.lips(animation)
        mine = [np.interp(times[inside], animation.times, one) for one in shown]
        real = lips[inside, 1:].T
        rs.append([np.corrcoef(a, b)[0, 1] for a, b in zip(mine, real, strict=True)])
        ours.append(mine)
        theirs.append(real)
        ids, bounds = head.sounds(schedule)
        for number, middle in zip(ids, (bounds[:-1] + bounds[1:]) / 2, strict=True):
            if times[inside][0] <= middle <= times[inside][-1]:
                both = (
                    np.interp(middle, animation.times, shown[0]),
                    np.interp(middle, times[inside], real[0]),
                )
                sounds[head.performer.compiled.phonemes[number]].append(both)
    aperture, width = np.nanmean(rs, axis=0)
    here, film = (spread(np.concatenate(one, axis=1)) for one in (ours, theirs))
    figures = {
        "aperture r": float(aperture), "width r": float(width),
        "aperture range": here["aperture SD"] / film["aperture SD"],
        "width range": here["width SD"] / film["width SD"],
    }  # fmt: skip
    return figures | here, film, sounds


def errors(sounds: Mapping[str, Sounds]) -> list[list[str]]:
    """Return a table of apertures by phoneme: of the films, and of each head beside them."""
    rows = [["aperture", "times", "film", *sounds]]
    counted = next(iter(sounds.values()))
    for name in sorted(counted, key=lambda one: -len(counted[one])):
        if len(counted[name]) >= LEAST_TIMES:
            film = np.mean([theirs for _, theirs in counted[name]])
            more = (np.mean([a - b for a, b in one[name]]) for one in sounds.values())
            told = [f"{one:+.2f}" for one in more]
            rows.append([name, str(len(counted[name])), f"{film:.2f}", *told])
    return rows


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
    rows, sounds = [], {}
    ahead = lead(next(iter(heads.values())), clips)
    print(
        f"{len(clips)} clips, measured on meshes; filmed lips are {ahead:.2f} s ahead of the sound"
    )
    for name, head in heads.items():
        figures, film, sounds[Path(name).stem] = judge(head, clips, ahead)
        if not rows:
            rows.append({"head": "film", **film})
        rows.append({
            "head": Path(name).stem, "poseset": head.performer.compiled.poseset, **figures
        })  # fmt: skip
    for row in rows:
        told = ", ".join(f"{key} {value:.2f}" for key, value in row.items() if key not in NAMES)
        print(" as ".join(row[key] for key in NAMES if key in row) + f": {told}")
    print(*columns(errors(sounds)), sep="\n")
    phonemes = {
        name: {
            phoneme: np.mean(both, axis=0).tolist()
            for phoneme, both in one.items()
            if len(both) >= LEAST_TIMES
        }
        for name, one in sounds.items()
    }
    found = {"clips": len(clips), "ahead": ahead, "rows": rows, "apertures": phonemes}
    json_figures.write_figures(options.json, found)


if __name__ == "__main__":
    main()
