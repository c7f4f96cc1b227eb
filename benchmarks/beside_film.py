"""Show a film of a person beside heads that say the same text: moving with sound, or in stills.

    python benchmarks/beside_film.py FOLDER CLIP OUT.mp4 [-c HEAD ...] [-l english]
    python benchmarks/beside_film.py FOLDER SOUND,SOUND OUT.png [--crop W:H:X:Y] [-c HEAD ...]

FOLDER is that of `face_on.py`, with the film of CLIP, whose text is aligned with its sound. Each
HEAD performs it at the rate of the film, which stands at the left, and its sound is heard.

A sheet (.png) shows the middle of each SOUND, a label or a common phoneme, in the sentence where it
has its median length: the film above, each head in the same moment of the same text below. `--crop`
is the part of the film that is shown, in pixels, as ffmpeg's filter takes it.
"""

import argparse
import subprocess
import sys
from collections import defaultdict
from collections.abc import Sequence
from io import BytesIO
from operator import itemgetter
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import shorten
from typing import NamedTuple

import numpy as np
from face_on import HEADS, Film, Head, filmed, lead

import lipsync_lang as ll
from lipsync_lang.render.model.camera import close_up
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.sheet import CELL, draw_stills, stacked
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.render.video import CODECS, film, find_ffmpeg

PIXELS = 480
"""Height of each picture."""

FPS = 25
"""Frames per second of the GRID corpus."""


class Moment(NamedTuple):
    """A moment of a film: the second of its sound, and its timed phonemes."""

    film: Film
    schedule: ll.Schedule
    seconds: float


def performed(head: str, schedule: ll.Schedule, language: str, out: Path) -> float:
    """Write the film of a head, and return the second at which its sound begins."""
    try:
        performer = ll.resolve(language, head)
        animation = performer.rigged(performer.perform(schedule, FPS))
        with out.open("wb") as stream:
            film(animation, stream, "mp4", size=PIXELS)
    except ll.LipsyncError as error:
        sys.exit(f"{head}: {error}")
    return staged(animation).sound


def beside(clip: Path, sound: Path, heads: dict[Path, float], out: Path) -> None:
    """Write the films side by side, each from the start of the sound."""
    inputs, films = ["-i", str(clip)], [clip, *heads]
    for path, start in heads.items():
        inputs += ["-ss", f"{start:.3f}", "-i", str(path)]
    numbers = range(len(films))
    scaled = (f"[{n}:v]fps={FPS},scale=-2:{PIXELS},setsar=1[v{n}]" for n in numbers)
    stacked = "".join(f"[v{n}]" for n in numbers) + f"hstack={len(films)}:shortest=1[all]"
    wanted = ["-filter_complex", ";".join((*scaled, stacked)), "-map", "[all]"]
    wanted += ["-map", f"{len(films)}:a", "-pix_fmt", "yuv420p", *CODECS["mp4"], str(out)]
    command = [find_ffmpeg(), "-loglevel", "error", "-nostdin", "-y", *inputs, "-i", str(sound)]
    subprocess.run([*command, *wanted], check=True)  # noqa: S603 no shell


def moments_of(
    films: dict[str, Film], sounds: Sequence[str], performer: ll.Performer
) -> list[Moment]:
    """Return the middle of each sound where the films have it with its median length."""
    shown = [one for one in films.values() if one.picture]
    language = performer.language
    schedules = ll.align([one.sound for one in shown], [one.text for one in shown], language)
    found: dict[str, list[tuple[float, Moment]]] = defaultdict(list)
    for one, schedule in zip(shown, schedules, strict=True):
        ids, bounds, _ = performer.common_phonemes(schedule)
        named = [performer.compiled.phonemes[number] for number in ids]
        spans = [*zip(named, bounds[:-1], bounds[1:], strict=True)]
        labels = (label.lower() for label in schedule.labels)
        spans += zip(labels, schedule.times[:-1], schedule.times[1:], strict=True)
        for name, start, end in spans:
            found[name].append((end - start, Moment(one, schedule, (start + end) / 2)))
    if absent := [one for one in sounds if one not in found]:
        sys.exit(f"no film has the sound {absent[0]}: {' '.join(sorted(found))}")
    ordered = [sorted(found[one], key=itemgetter(0)) for one in sounds]
    return [one[len(one) // 2][1] for one in ordered]


def frame(moment: Moment, ahead: float, crop: str) -> np.ndarray:
    """Return the part of the film that is shown, (CELL, CELL, 3)."""
    look = f"crop={crop},scale={CELL}:{CELL}"
    wanted = ["-vf", look, "-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    at = ["-ss", f"{max(0.0, moment.seconds - ahead):.3f}", "-i", str(moment.film.picture)]
    command = [find_ffmpeg(), "-loglevel", "error", "-nostdin", *at, *wanted]
    ended = subprocess.run(command, capture_output=True, check=False)  # noqa: S603 no shell
    if len(ended.stdout) != CELL * CELL * 3:
        why = ended.stderr.decode(errors="replace").strip() or "it ends before"
        sys.exit(f"{moment.film.picture}: no frame at {moment.seconds:.2f} s: {why}")
    return np.frombuffer(ended.stdout, np.uint8).reshape(CELL, CELL, 3)


def face(performer: ll.Performer, moment: Moment) -> np.ndarray:
    """Return the mouth of a head in the same moment, (CELL, CELL, 3)."""
    animation = performer.rigged(performer.perform(moment.schedule, FPS))
    scene, swept = staged(animation), staged(sweep(animation))
    return Artist(scene, CELL, close_up(swept), swept).draw(moment.seconds + scene.sound)


def sheet(options: argparse.Namespace, films: dict[str, Film], heads: Sequence[str]) -> None:
    """Write the stills of some sounds."""
    sounds = options.clip.lower().split(",")
    shown = {name: Head.of(name, options.language, seen=False) for name in heads}
    first = next(iter(shown.values()))
    moments = moments_of(films, sounds, first.performer)
    known = [(one.schedule, one.film.lips) for one in moments if one.film.lips is not None]
    ahead = lead(first, known) if known else 0.0
    rows = {"film": [frame(one, ahead, options.crop) for one in moments]}
    rows |= {
        Path(name).stem: [face(head.performer, one) for one in moments]
        for name, head in shown.items()
    }
    stills = [
        (one.seconds, sound, f"{shorten(one.film.text, 24, placeholder='…')} · {one.seconds:.2f} s")
        for sound, one in zip(sounds, moments, strict=True)
    ]
    sheets = {}
    for name, cells in rows.items():
        cell_at = dict(zip((seconds for seconds, *_ in stills), cells, strict=True))
        draw_stills(stills, cell_at.__getitem__, row := BytesIO(), len(stills))
        sheets[name] = row.getvalue()
    with options.out.open("wb") as stream:
        stacked(sheets, stream)


def moving(options: argparse.Namespace, films: dict[str, Film], heads: Sequence[str]) -> None:
    """Write the moving picture of a clip."""
    clips = sorted(name for name, one in films.items() if one.picture)
    if options.clip not in clips:
        sys.exit(f"{options.clip} is no film of {options.folder}: {' '.join(clips)}")
    clip = films[options.clip]
    schedule = ll.align(clip.sound, clip.text, options.language)
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{number}.mp4" for number in range(len(heads))]
        starts = [
            performed(head, schedule, options.language, path)
            for head, path in zip(heads, paths, strict=True)
        ]
        beside(clip.picture, clip.sound, dict(zip(paths, starts, strict=True)), options.out)


def main() -> None:
    """Write the moving picture, or the sheet."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("clip", help="for a sheet, sounds: aa,iy,w")
    parser.add_argument("out", type=Path)
    parser.add_argument(
        "--crop", default="ih:ih", metavar="W:H:X:Y", help="of the film, in a sheet"
    )
    parser.add_argument("-c", "--character", action="append", metavar="HEAD")
    parser.add_argument("-l", "--language", default="english")
    options = parser.parse_args()
    films = filmed(options.folder)
    if find_ffmpeg() is None:
        sys.exit("a film needs ffmpeg: the extra `video` brings one")
    heads = options.character or [*HEADS]
    show = sheet if options.out.suffix.lower() == ".png" else moving
    show(options, films, heads)
    print(
        f"{options.out}: {options.clip} by the film, {', '.join(Path(one).stem for one in heads)}"
    )


if __name__ == "__main__":
    main()
