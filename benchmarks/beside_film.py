"""Show a film of a person beside heads that say the same text, as one moving picture with sound.

    python benchmarks/beside_film.py FOLDER CLIP OUT.mp4 [-c HEAD ...] [-l english]

FOLDER is that of `face_on.py`, with the film of CLIP, whose text is aligned with its sound. Each
HEAD performs it at the rate of the film, which stands at the left, and its sound is heard.
"""

import argparse
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from face_on import HEADS, filmed

import lipsync_lang as ll
from lipsync_lang.render.staging import staged
from lipsync_lang.render.video import CODECS, film, find_ffmpeg

PIXELS = 480
"""Height of each picture."""

FPS = 25
"""Frames per second of the GRID corpus."""


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


def main() -> None:
    """Write the moving picture."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("clip")
    parser.add_argument("out", type=Path)
    parser.add_argument("-c", "--character", action="append", metavar="HEAD")
    parser.add_argument("-l", "--language", default="english")
    options = parser.parse_args()
    films = filmed(options.folder)
    clips = sorted(name for name, one in films.items() if one.picture)
    if options.clip not in clips:
        sys.exit(f"{options.clip} is no film of {options.folder}: {' '.join(clips)}")
    if find_ffmpeg() is None:
        sys.exit("a moving picture needs ffmpeg: the extra `video` brings one")
    clip = films[options.clip]
    schedule = ll.align(clip.sound, clip.text, options.language)
    with TemporaryDirectory() as folder:
        heads = options.character or [*HEADS]
        paths = [Path(folder) / f"{number}.mp4" for number in range(len(heads))]
        starts = [
            performed(head, schedule, options.language, path)
            for head, path in zip(heads, paths, strict=True)
        ]
        beside(clip.picture, clip.sound, dict(zip(paths, starts, strict=True)), options.out)
    print(f"{options.out}: {clip.text!r} by the film, {', '.join(Path(one).stem for one in heads)}")


if __name__ == "__main__":
    main()
