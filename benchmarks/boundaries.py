"""Errors of alignment in a folder of labelled recordings, in any language.

    python benchmarks/boundaries.py FOLDER -l LANGUAGE [--notation NAME] [--aligner NAME]
        [--beside] [--json FILE]

Each recording `NAME.wav` (or .flac, .ogg, .mp3) has its labels beside it in any readable format of
timings, such as `NAME.TextGrid`. Its text is in `NAME.txt`; without one, the words of the labels
are the text. `--beside` measures the recordings with noise and with music under the voice, too.

A boundary counts where the phonemes on both sides are the same in both (`alignment.py` says how
they are paired). Closures are judged where they can be heard (`closures.py`), and counted if they
are off by more than two frames of 60. Errors are in milliseconds.
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import json_figures
import numpy as np
from alignment import SNR, errors, noisy
from closures import FRAMES_OFF, by_place, closures, print_places
from hearing import music

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.schedules import Schedule
from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.schedules.timing_readers import read_schedule
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.sound import AUDIO_SUFFIXES, read_audio, resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines.plain import TIMING_SUFFIXES

RATE = 16_000
FAR_SECONDS = 0.1
LABEL_SUFFIXES = {*TIMING_SUFFIXES} - {".txt"}


class Labelled(NamedTuple):
    """A text, and its known phonemes with their sound."""

    text: str
    known: Schedule


def labelled(folder: Path, notation: str | None) -> Iterator[Labelled]:
    """Yield the recordings of a folder that have labels and a text; name those that do not."""
    for sound in sorted(p for p in folder.rglob("*") if p.suffix.lower() in AUDIO_SUFFIXES):
        beside = (one for one in sorted(sound.parent.iterdir()) if one.stem == sound.stem)
        labels = next((one for one in beside if one.suffix.lower() in LABEL_SUFFIXES), None)
        if labels is None:
            print(f"{sound}: has no labels beside it", file=sys.stderr)
            continue
        try:
            known = replace(read_schedule(labels, notation), audio=read_audio(sound))
        except LipsyncError as error:
            print(error, file=sys.stderr)
            continue
        script = sound.with_suffix(".txt")
        text = script.read_text("utf-8") if script.exists() else ""
        text = text.strip() or " ".join(word.text for word in known.words)
        if text:
            yield Labelled(text, known)
        else:
            print(f"{sound}: has no text; write {script}", file=sys.stderr)


def measured(
    name: str, lines: list[Labelled], speaker: Speaker, aligner: str | None
) -> dict[str, Any]:
    """Align lines with their texts, and print a row of the table."""
    off: list[float] = []
    lips: list[tuple[str, float]] = []
    doubted = failed = 0
    for text, known in lines:
        try:
            found = aligned(speaker, known.audio, text, aligner=aligner)
        except LipsyncError as error:
            failed += 1
            print(error, file=sys.stderr)
            continue
        doubted += (found.confidence or 1.0) < DOUBTFUL
        off += errors(found, known, speaker)
        lips += closures(found, known, speaker)
    if not off:
        print(f"{name}: no boundary is paired; check the notation of the labels (`--notation`)")
        return {"name": name, "lines": len(lines), "failed": failed}
    late, pressed = np.array(off), np.array([seconds for _, seconds in lips])
    row = json_figures.boundary_errors(late) | {
        "name": name,
        "lines": len(lines),
        "closures": len(lips),
        "closures_off": np.mean(np.abs(pressed) > FRAMES_OFF) if lips else None,
        "places": by_place(lips),
        "far": np.mean(np.abs(late) > FAR_SECONDS),
        "doubted": doubted,
        "failed": failed,
    }
    share = "-" if row["closures_off"] is None else f"{row['closures_off']:.0%}"
    print(
        f"{name:16}{len(lines):6}{len(late):7}{row['median_ms']:8.1f}{row['p90_ms']:8.1f}"
        f"{row['late_ms']:+7.1f}{share:>10}{row['far']:9.1%}{doubted:9}{failed:8}",
        flush=True,
    )
    print_places(row["places"])
    return row


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-l", "--language", required=True)
    parser.add_argument("--notation", help="of the labels [stated by the file, or IPA]")
    parser.add_argument("--aligner")
    parser.add_argument("--beside", action="store_true", help="with noise and music as well")
    json_figures.add_option(parser)
    options = parser.parse_args()
    speaker = Speaker.of(options.language)
    lines = list(labelled(options.folder, options.notation))
    if not lines:
        parser.error(f"{options.folder} has no recording with labels and a text")
    titles = (
        "lines",
        "pairs",
        "median",
        "90 %",
        "late",
        "closures",
        ">100 ms",
        "doubted",
        "failed",
    )
    widths = (6, 7, 8, 8, 7, 10, 9, 9, 8)
    print(" " * 16 + "".join(f"{t:>{w}}" for t, w in zip(titles, widths, strict=True)))
    rows = [measured("as recorded", lines, speaker, options.aligner)]
    under = {"noise": np.random.default_rng(0).normal(size=30 * RATE), "music": music(30.0)}
    for name, sound in under.items() if options.beside else ():
        mixed = [
            line._replace(
                known=replace(line.known, audio=noisy(resampled(line.known.audio, RATE), sound))
            )
            for line in lines
        ]
        rows.append(measured(f"{name}, {SNR:g} dB", mixed, speaker, options.aligner))
    json_figures.write_figures(options.json, {"rows": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
