"""Compare the lips of our heads with those of filmed people who say the same texts.

    python benchmarks/face_on.py FOLDER [-c HEAD ...] [-l english] [--clip NAME ...] [--all]
                                 [--methods] [--tracker PYTHON [--render]] [--json FILE]

FOLDER holds films with their texts (NAME.mp4, NAME.txt); or it holds `NAME_texts.tsv` (clip, text),
`NAME_sound/CLIP.ogg`, lips that are tracked already, `NAME_lips.tsv.gz` (clip, second, inner_gap,
width, in any unit), and perhaps `NAME/CLIP.mpg`. Each text is aligned with its sound, and each HEAD
(a model, or a character with one) performs it. Its lips are measured on its mesh, which is quick.
With --render it is drawn, and tracked as the films are. PYTHON, an environment with mediapipe
0.10.14 (1.2 GB), tracks films whose lips are not known, and drawn heads. --methods moves the first
head by plain methods, too.

Mouths of `languages/common.yaml` were learnt from 170 sentences of the GRID speaker s1. Of many
clips, therefore, the first twenty of every ninth are judged; --all judges each clip of a folder
that nothing was learnt from.

aperture r, width r   Pearson's r over the frames of speech, the mean of all clips
range                 our standard deviation divided by that of the film
95 %, 5 %, SD         percentiles and standard deviation, in widths of the mouth
lag ms                how late our aperture is: the shift of the largest r
shut %                lip contacts of the text that are seen shut

Filmed lips are somewhat ahead of their sound; the program finds by how much, and compares them
there. A table follows for aperture and for width: the film at the middle of each phoneme, and how
much more each head has there.
"""

import argparse
import csv
import gzip
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import json_figures
import numpy as np

import lipsync_lang as ll
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.render.staging import staged
from lipsync_lang.render.video import film
from lipsync_lang.reports.quality.baselines import held, keyframes
from lipsync_lang.reports.quality.face_columns import SeenMouth, face_of

EVERY, JUDGED = 9, 20
"""The clips that mouths were not learnt from."""

HEADS = ("facefx",)
KINDS = {".mp4", ".mov", ".mkv", ".webm", ".mpg"}
MEASURES = ("aperture", "width")

FPS = 100
"""Frames per second on a mesh; a head is drawn at the rate of the film."""

PIXELS = 480
"""Side of a drawn frame: as large as the face in a common film."""

LEADS = np.arange(-0.1, 0.101, 0.01).round(2)
"""Seconds by which filmed lips may be ahead of their sound."""

LAGS = np.arange(-0.15, 0.151, 0.005).round(3)
"""Seconds by which ours may be late."""

SHUT = 0.1
"""Share of a film's widest aperture (its 95th percentile) below which lips are shut."""

SHUTS = "bmp"
"""The common phoneme that shuts the lips."""

LEAST_TIMES = 5
"""Smallest number of a phoneme in the table of errors."""

Lips = np.ndarray
"""(T, 3) seconds of the sound, aperture and width, in widths of the mouth."""

Clips = list[tuple[ll.Schedule, Lips]]

Sounds = dict[str, list[np.ndarray]]
"""Our lips at the middle of a phoneme, and those of the film, (2, 2), by its name."""


class Film(NamedTuple):
    """A text, how it sounds and how it looks."""

    text: str
    sound: Path
    lips: Lips | None
    """None if they are not tracked."""
    picture: Path | None


class Head(NamedTuple):
    """A performer, the mouth on its mesh, and how it performs."""

    performer: ll.Performer
    seen: SeenMouth | None
    perform: Callable[[ll.Schedule, float], ll.Animation]

    @classmethod
    def of(cls, name: str, language: str, *, seen: bool = True) -> "Head":
        """Read a head; end with a sentence if it has no model, or no mouth that is `seen`."""
        try:
            performer = ll.resolve(language, name)
            if performer.model is None:
                sys.exit(f"{name} has no model; name one, such as -c head.glb")
            mouth = face_of(performer.perform(ll.Schedule(("_",), [0, 1])), performer).seen
        except ll.LipsyncError as error:
            sys.exit(f"{name}: {error}")
        if mouth is None and seen:
            sys.exit(f"{name}: the mouth of {performer.model} cannot be measured; use --render")
        return cls(performer, mouth, performer.perform)

    def lips(self, animation: ll.Animation) -> Lips:
        """Return the lips of each frame, measured on the mesh."""
        count = self.seen.gains.shape[1]
        aperture, width = (self.seen.gains @ animation.weights[:, :count].T)[:2]
        return np.column_stack([animation.times, np.maximum(0.0, aperture), width])

    def sounds(self, schedule: ll.Schedule) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of the common phonemes of a line, and their bounds."""
        track = self.performer.track(schedule)
        return track.ids, track.bounds


def filmed(folder: Path) -> dict[str, Film]:
    """Return the clips of a folder by name; end with a sentence if there are none."""
    found = {}
    pictures = {one.stem: one for one in sorted(folder.rglob("*")) if one.suffix.lower() in KINDS}
    for texts in sorted(folder.glob("*_texts.tsv")):
        name = texts.name.removesuffix("_texts.tsv")
        try:
            lips = tracked_before(folder / f"{name}_lips.tsv.gz")
            with texts.open(encoding="utf-8") as stream:
                for row in csv.DictReader(stream, delimiter="\t"):
                    clip, sound = row["clip"], folder / f"{name}_sound" / f"{row['clip']}.ogg"
                    found[clip] = Film(row["text"], sound, lips.get(clip), pictures.get(clip))
        except (OSError, KeyError, ValueError) as error:
            sys.exit(f"{texts}, or the lips beside it: {type(error).__name__}: {error}")
    for name, picture in pictures.items():
        text = picture.with_suffix(".txt")
        if name not in found and text.exists():
            found[name] = Film(text.read_text("utf-8").strip(), picture, None, picture)
    if not found:
        sys.exit(
            f"{folder} holds no films with a text: it needs NAME.mp4 beside NAME.txt, "
            "or NAME_texts.tsv beside NAME_lips.tsv.gz and NAME_sound/"
        )
    return found


def tracked_before(file: Path) -> dict[str, Lips]:
    """Read the lips of clips by name."""
    rows = defaultdict(list)
    with gzip.open(file, "rt", encoding="utf-8") as stream:
        for row in csv.DictReader(stream, delimiter="\t"):
            values = (row[key] for key in ("second", "inner_gap", "width"))
            rows[row["clip"]].append([float(value or "nan") for value in values])
    return dict(zip(rows, scaled([np.array(one) for one in rows.values()]), strict=True))


def scaled(clips: Sequence[Lips]) -> list[Lips]:
    """Return the lips of one face in widths of its mouth, and its width less the usual one."""
    width = np.nanmedian([np.nanmedian(one[:, 2]) for one in clips])
    return [one / (1.0, width, width) - (0.0, 0.0, 1.0) for one in clips]


def tracked(python: str, path: Path, start: float = 0.0) -> Lips:
    """Track the lips of a film whose sound begins at the second `start`."""
    with TemporaryDirectory() as folder:
        out = Path(folder) / "lips.npz"
        command = [python, Path(__file__).with_name("track_lips.py"), path, out]
        try:
            ended = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 no shell
        except OSError as error:
            sys.exit(f"--tracker {python}: {error.strerror}")
        if ended.returncode:
            sys.exit(f"{path}: the tracker failed: {ended.stderr.strip().splitlines()[-1]}")
        with np.load(out) as found:
            shape, fps = found["lips"], float(found["fps"])
    lost = np.isnan(shape[:, 0]).mean()
    if lost == 1:
        sys.exit(f"{path}: the tracker finds no face")
    print(f"{path.name}: {len(shape)} frames, {lost:.0%} without a face", file=sys.stderr)
    return np.column_stack([np.arange(len(shape)) / fps - start, shape])


def measured(head: Head, clips: Clips) -> list[Lips]:
    """Return the lips of a head that performs each clip, from its mesh."""
    return [head.lips(head.perform(schedule, FPS)) for schedule, _ in clips]


def rendered(head: Head, clips: Clips, tracker: str) -> list[Lips]:
    """Return the lips of a head that performs each clip, as they are tracked in its pictures."""
    found = []
    for number, (schedule, lips) in enumerate(clips):
        fps = 1 / float(np.median(np.diff(lips[:, 0])))
        animation = head.performer.rigged(head.perform(schedule, fps))
        with TemporaryDirectory() as folder:
            path = Path(folder) / f"{head.performer.character}-{number + 1}.mp4"
            with path.open("wb") as stream:
                film(animation, stream, "mp4", size=PIXELS)
            found.append(tracked(tracker, path, staged(animation).sound))
    return scaled(found)


def lead(head: Head, clips: Clips) -> float:
    """Return the seconds by which the lips of the films are ahead of their sound.

    The apertures that sounds have in film make a course of steps, which fits the lips best there.
    """
    if head.seen is None:
        return 0.0
    found = []
    for ahead in LEADS:
        rs = []
        for schedule, lips in clips:
            ids, bounds = head.sounds(schedule)
            at = np.searchsorted(bounds, lips[:, 0] + ahead, "right") - 1
            inside = (at > 0) & (at < len(ids) - 1)
            steps = np.full(len(at), np.nan)
            steps[inside] = head.seen.apertures[ids[at[inside]]]
            rs.append(correlate(steps, lips[:, 1]))
        found.append(np.nanmean(rs))
    return float(LEADS[int(np.argmax(found))])


def correlate(real: np.ndarray, ours: np.ndarray) -> float:
    """Return Pearson's r over the frames where both faces were found; 0 if ours never moves."""
    both = np.isfinite(real) & np.isfinite(ours)
    if both.sum() < 3 or not np.ptp(real[both]):
        return float("nan")
    if not np.ptp(ours[both]):
        return 0.0
    return float(np.corrcoef(real[both], ours[both])[0, 1])


def shut(lips: Lips, spans: np.ndarray) -> list[bool]:
    """Return of each span, (n, 2) seconds, whether the lips are seen shut in it."""
    times, aperture = lips[:, 0], lips[:, 1]
    limit = SHUT * np.nanquantile(aperture, 0.95)
    near = np.median(np.diff(times)) / 2
    seen = (aperture[(times >= a - near) & (times <= b + near)] for a, b in spans)
    return [bool(np.nanmin(one, initial=np.inf) <= limit) for one in seen]


def spread(lips: Lips, closed: Sequence[bool]) -> dict[str, float]:
    """Return how far the lips of all clips open, change their width, and shut."""
    low, high = np.percentile(lips[:, 2], (5, 95))
    found = {
        "aperture 95 %": float(np.percentile(lips[:, 1], 95)),
        "width 5 %": float(low), "width 95 %": float(high),
        "aperture SD": float(lips[:, 1].std()), "width SD": float(lips[:, 2].std()),
    }  # fmt: skip
    return found | ({"shut %": 100 * float(np.mean(closed))} if closed else {})


def at(times: np.ndarray, lips: Lips) -> Lips:
    """Return lips at other seconds, between the frames where they were found."""
    known = lips[np.isfinite(lips).all(axis=1)].T
    return np.column_stack([times, *(np.interp(times, known[0], one) for one in known[1:])])


def judge(
    head: Head, clips: Clips, ahead: float, shown: Sequence[Lips] | None = None
) -> tuple[dict[str, float], dict[str, float], Sounds]:
    """Return figures of a head, those of the films, and the lips at each phoneme in both."""
    rs, late, ours, theirs = [], [], [], []
    our_shut: list[bool] = []
    their_shut: list[bool] = []
    sounds: Sounds = defaultdict(list)
    phonemes = head.performer.compiled.phonemes
    for (schedule, lips), mine in zip(clips, shown or measured(head, clips), strict=True):
        film = np.add(lips, (ahead, 0.0, 0.0))
        speech = (film[:, 0] >= schedule.times[1]) & (film[:, 0] <= schedule.times[-2])
        film = film[speech & np.isfinite(film).all(axis=1)]
        times = film[:, 0]
        ours.append(at(times, mine))
        theirs.append(film)
        rs.append([correlate(film[:, n], ours[-1][:, n]) for n in (1, 2)])
        late.append([correlate(film[:, 1], at(times + lag, mine)[:, 1]) for lag in LAGS])
        ids, bounds = head.sounds(schedule)
        names = [phonemes[one] for one in ids]
        spans = np.column_stack([bounds[:-1], bounds[1:]])[np.array(names) == SHUTS]
        our_shut += shut(mine, spans)
        their_shut += shut(film, spans)
        middles = (bounds[:-1] + bounds[1:]) / 2
        both = np.stack([at(middles, one)[:, 1:] for one in (mine, film)], axis=1)
        for name, middle, one in zip(names, middles, both, strict=True):
            if times[0] <= middle <= times[-1]:
                sounds[name].append(one)
    here = spread(np.concatenate(ours), our_shut)
    real = spread(np.concatenate(theirs), their_shut)
    figures = dict(zip((f"{one} r" for one in MEASURES), np.nanmean(rs, axis=0), strict=True))
    figures |= {f"{one} range": here[f"{one} SD"] / real[f"{one} SD"] for one in MEASURES}
    figures["lag ms"] = 1000 * LAGS[int(np.nanargmax(np.nanmean(late, axis=0)))]
    return figures | here, real, sounds


def errors(sounds: Mapping[str, Sounds], measure: int) -> list[list[str]]:
    """Return a table of a measure by phoneme: of the films, and of each head beside them."""
    rows = [[MEASURES[measure], "times", "film", *sounds]]
    counted = next(iter(sounds.values()))
    for name in sorted(counted, key=lambda one: -len(counted[one])):
        if len(counted[name]) >= LEAST_TIMES:
            pairs = [np.mean(one[name], axis=0)[:, measure] for one in sounds.values()]
            more = [f"{ours - theirs:+.2f}" for ours, theirs in pairs]
            rows.append([name, str(len(counted[name])), f"{pairs[0][1]:.2f}", *more])
    return rows


def told(value: str | float) -> str:
    """Return a cell of the table of figures."""
    return value if isinstance(value, str) else f"{value:.3g}"


def moved(first: Head) -> dict[str, Head]:
    """Return the first head moved by plain methods, by their names."""
    performer = first.performer
    # plain methods read targets from packs, and a model has none of its own
    plain = ll.resolve(performer.language, performer.compiled.poseset)
    return {
        "paper's motion": first._replace(perform=performer.with_motion("paper").perform),
        "keyframes at centres": first._replace(perform=partial(keyframes, plain)),
        "held shapes": first._replace(perform=partial(held, plain)),
    }


def clips_of(options: argparse.Namespace) -> Clips:
    """Return the timed phonemes and the filmed lips of the clips that are judged."""
    films = filmed(options.folder)
    names = sorted(films)
    if unknown := sorted({*(options.clip or ())} - films.keys()):
        sys.exit(f"{unknown[0]} is no clip of {options.folder}: {' '.join(names)}")
    if len(names) > JUDGED and not options.all:
        names = names[::EVERY][:JUDGED]
    names = options.clip or names
    chosen = [films[name] for name in names]
    lips = [one.lips for one in chosen]
    for number, (name, one) in enumerate(zip(names, chosen, strict=True)):
        if one.lips is None:
            if options.tracker is None or one.picture is None:
                sys.exit(f"{name}: its lips are not tracked; name a --tracker, and have its film")
            lips[number] = scaled([tracked(options.tracker, one.picture)])[0]
    sounds, texts = [one.sound for one in chosen], [one.text for one in chosen]
    try:
        schedules = [*ll.align(sounds, texts, options.language)]
    except ll.LipsyncError as error:
        sys.exit(str(error))
    return [*zip(schedules, lips, strict=True)]


def main() -> None:
    """Print a row for each head, and the tables of phonemes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-c", "--character", action="append", metavar="HEAD")
    parser.add_argument("-l", "--language", default="english")
    parser.add_argument("--clip", action="append", metavar="NAME", help="judge this one only")
    parser.add_argument("--all", action="store_true", help="judge every clip")
    parser.add_argument("--methods", action="store_true", help="move the first head plainly, too")
    parser.add_argument("--tracker", metavar="PYTHON", help="has mediapipe 0.10.14")
    parser.add_argument("--render", action="store_true", help="draw heads and track their pictures")
    json_figures.add_option(parser)
    options = parser.parse_args()
    if options.render and options.tracker is None:
        sys.exit("--render needs a --tracker, the Python of an environment with mediapipe 0.10.14")
    named = options.character or HEADS
    stems = [Path(one).stem for one in named]
    labels = [
        stem if stems.count(stem) == 1 else one for one, stem in zip(named, stems, strict=True)
    ]
    heads = {
        label: Head.of(one, options.language, seen=not options.render)
        for label, one in zip(labels, named, strict=True)
    }
    first = next(iter(heads.values()))
    if options.methods:
        heads |= moved(first)
    clips = clips_of(options)
    ahead = lead(first, clips)
    how = "tracked in pictures" if options.render else "measured on meshes"
    print(f"{len(clips)} clips, {how}; filmed lips are {ahead:.2f} s ahead of the sound")
    rows: list[dict[str, str | float]] = []
    sounds = {}
    for name, head in heads.items():
        shown = rendered(head, clips, options.tracker) if options.render else None
        figures, real, sounds[name] = judge(head, clips, ahead, shown)
        if not rows:
            rows.append({"head": "film", **real})
        rows.append({"head": name, "poseset": head.performer.compiled.poseset, **figures})
    cells = [[key, *(told(row.get(key, "")) for row in rows)] for key in rows[1]]
    for table in (cells, *(errors(sounds, one) for one in range(len(MEASURES)))):
        if len(table) > 1:
            print("", *columns(table), sep="\n")
    apertures = {
        name: {
            phoneme: np.mean(both, axis=0)[:, 0].tolist()
            for phoneme, both in one.items()
            if len(both) >= LEAST_TIMES
        }
        for name, one in sounds.items()
    }
    found = {"clips": len(clips), "ahead": ahead, "rows": rows, "apertures": apertures}
    json_figures.write_figures(options.json, found)


if __name__ == "__main__":
    main()
