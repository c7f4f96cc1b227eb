"""Draw the lips of one filmed sentence beside those of its text, of its words, and of its sound.

    python benchmarks/lips_of_takes.py FOLDER [CLIP OUT.png] [-c HEAD] [-l english] [--delay 0.08]
        [--whisper MODEL] [--json FILE]

FOLDER is that of `face_on.py`, with tracked lips. Four takes of CLIP are performed on HEAD and
measured on its mesh: by the text, aligned with the sound; by the words that Whisper hears; by the
sound of the whole file (the recogniser `sound`); and live, with a delay. Whisper is left out, with
a sentence, where it or its model is missing. Each take is shown with Pearson's r to the film over
the frames of speech. The lead of the filmed lips over their sound is that of the clips that
`face_on.py` judges. Without CLIP, a table states the means over these clips.

found    closures of the text that the film shows, which a take shows within 50 ms
as film  closures of a take, within 50 ms of lips that are shut in the film
"""

import argparse
import sys
from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING

import json_figures
import numpy as np
from face_on import (
    EVERY,
    HEADS,
    JUDGED,
    SHUT,
    SHUTS,
    Clips,
    Film,
    Head,
    Lips,
    at,
    correlate,
    filmed,
    lead,
)
from listening import listened, near, sound_of, stretches
from matplotlib.figure import Figure
from PIL import Image

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation
from lipsync_lang.sound.speech.sound import read_audio

if TYPE_CHECKING:
    from collections.abc import Callable

FPS = 100

Figures = dict[str, list[float]]

FILM, TAKES = "#222222", ("#1b6ca8", "#2a9d5c", "#d9822b", "#b5308a")
"""Colours of the film, and of the takes in their order."""

DASHES = ("-", (0, (4, 4)), "-", "-")
"""Lines of the takes: where Whisper hears the text, both curves are one."""

PANELS = ("distance of the lips", "width of the mouth, less the usual one")


def takes(
    head: Head, text: str, audio: ll.Audio, asked: argparse.Namespace
) -> dict[str, Animation]:
    """Return the animation of each take by its name."""
    performer = head.performer

    def live() -> Animation:
        times, weights = listened(performer, sound_of(audio), asked.delay, FPS)
        return Animation(times, performer.poses, weights, FPS, ll.Schedule(("_",), [0, 1]))

    def heard(recogniser: str) -> Animation:
        return performer.perform(ll.recognise(audio, asked.language, recogniser=recogniser), FPS)

    whisper = f"whisper:{asked.whisper}" if asked.whisper else "whisper"
    makers: dict[str, Callable[[], Animation]] = {
        "text": lambda: performer.perform(ll.align(audio, text, asked.language), FPS),
        "Whisper's words": lambda: heard(whisper),
        "whole file": lambda: heard("sound"),
        f"live, {asked.delay * 1000:.0f} ms": live,
    }
    found = {}
    for name, make in makers.items():
        try:
            found[name] = make()
        except ll.LipsyncError as error:
            print(f"{name} is left out: {str(error).splitlines()[0]}", file=sys.stderr)
    return found


def spoken(film: Lips, schedule: ll.Schedule) -> Lips:
    """Return the frames of speech in which the film has lips."""
    inside = (film[:, 0] >= schedule.times[1]) & (film[:, 0] <= schedule.times[-2])
    return film[inside & np.isfinite(film).all(axis=1)]


def rs(film: Lips, mine: Lips) -> list[float]:
    """Return Pearson's r of aperture and of width to the film."""
    ours = at(film[:, 0], mine)
    return [correlate(film[:, number], ours[:, number]) for number in (1, 2)]


def closures(film: Lips, mine: Lips, spans: list[list[float]]) -> list[int]:
    """Count spans shut in film, those of them that we shut, our closures, and those in film."""
    theirs, ours = (
        stretches(one[:, 0], one[:, 1] <= SHUT * np.nanquantile(one[:, 1], 0.95))
        for one in (film, mine[(mine[:, 0] >= film[0, 0]) & (mine[:, 0] <= film[-1, 0])])
    )
    seen = [one for one in spans if near(one, theirs, np.diff(film[:, 0]).max() / 2)]
    return [
        len(seen), sum(near(one, ours) for one in seen),
        len(ours), sum(near(one, theirs) for one in ours),
    ]  # fmt: skip


def drawn(film: Lips, lips: dict[str, Lips], schedule: ll.Schedule) -> tuple[Figure, Figures]:
    """Draw the film and the takes; return the figure, and both r of each take."""
    figure = Figure((10, 6.2), layout="constrained")
    panels = figure.subplots(2, sharex=True)
    times = film[:, 0]
    figures = {name: rs(spoken(film, schedule), shown) for name, shown in lips.items()}
    looks = [*zip(TAKES, DASHES, strict=True)]
    for number, (panel, title) in enumerate(zip(panels, PANELS, strict=True)):
        real = film[:, 1 + number]
        panel.plot(times, real, color=FILM, lw=2.6, label="film")
        for (name, shown), (colour, dash) in zip(lips.items(), looks, strict=False):
            moments, *curves = shown.T
            label = f"{name}: r {figures[name][number]:.2f}"
            panel.plot(moments, curves[number], color=colour, lw=1.6, ls=dash, label=label)
        panel.set_title(f"{title}, in widths of the mouth", loc="left", fontsize=10)
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9)
        panel.spines[["top", "right"]].set_visible(False)
        panel.set_xlim(schedule.times[1] - 0.2, schedule.times[-2] + 0.2)
        for word in schedule.words:
            panel.axvline(word.start, color="#dddddd", lw=0.8, zorder=0)
    lowest = panels[1].get_ylim()[0]
    for word in schedule.words:
        middle = (word.start + word.end) / 2
        panels[1].text(middle, lowest, word.text, ha="center", va="bottom", fontsize=9)
    panels[1].set_xlabel("seconds")
    return figure, figures


def means(head: Head, films: list[Film], clips: Clips, asked: argparse.Namespace) -> Figures:
    """Print r and closures of each take over some clips, and return them."""
    rows: dict[str, list[list[float]]] = defaultdict(list)
    for one, (schedule, lips) in zip(films, clips, strict=True):
        film = spoken(lips, schedule)
        ids, bounds = head.sounds(schedule)
        shuts = [head.performer.compiled.phonemes[number] == SHUTS for number in ids]
        spans = stretches(bounds, np.array([*shuts, False]), 0)
        for name, take in takes(head, one.text, read_audio(one.sound), asked).items():
            mine = head.lips(take)
            rows[name].append([*rs(film, mine), *closures(film, mine, spans)])
    print(f"{len(clips)} clips          aperture r   width r   found   as film")
    found = {}
    for name, one in rows.items():
        aperture, width = np.nanmean(one, axis=0)[:2]
        seen, shut, shown, right = np.sum(one, axis=0)[2:]
        found[name] = [float(value) for value in (aperture, width, shut / seen, right / shown)]
        print(f"{name:18}{aperture:10.3f}{width:10.3f}{shut / seen:8.0%}{right / shown:10.0%}")
    return found


def main() -> None:
    """Draw the picture, and print r of each take."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("clip", nargs="?")
    parser.add_argument("out", type=Path, nargs="?")
    parser.add_argument("-c", "--character", default=HEADS[0], metavar="HEAD")
    parser.add_argument("-l", "--language", default="english")
    parser.add_argument("--delay", type=float, default=0.08, help="of the live take [0.08]")
    parser.add_argument(
        "--whisper", metavar="MODEL", help="Whisper's model; the usual one unless stated"
    )
    json_figures.add_option(parser)
    asked = parser.parse_args()
    films = filmed(asked.folder)
    if asked.clip is not None and (asked.clip not in films or asked.out is None):
        sys.exit(f"name a clip of {asked.folder} and a picture: {', '.join(sorted(films)[:8])} ...")
    head = Head.of(asked.character, asked.language)
    some = [films[name] for name in sorted(films)[::EVERY][:JUDGED]]
    schedules = ll.align([one.sound for one in some], [one.text for one in some], asked.language)
    clips: Clips = [(one, film.lips) for one, film in zip(schedules, some, strict=True)]
    ahead = lead(head, clips), 0.0, 0.0
    if asked.clip is None:
        clips = [(schedule, np.add(lips, ahead)) for schedule, lips in clips]
        json_figures.write_figures(asked.json, means(head, some, clips, asked))
        return
    clip = films[asked.clip]
    film = np.add(clip.lips, ahead)
    made = takes(head, clip.text, read_audio(clip.sound), asked)
    lips = {name: head.lips(one) for name, one in made.items()}
    figure, figures = drawn(film, lips, made["text"].schedule)
    figure.savefig(asked.out, dpi=100)
    # few colours make a small file
    page = Image.open(asked.out).convert("RGB")
    page.quantize(256, dither=Image.Dither.NONE).save(asked.out, optimize=True)
    for name, (aperture, width) in figures.items():
        print(f"{name:18} aperture r {aperture:.2f}, width r {width:.2f}")
    json_figures.write_figures(asked.json, figures)


if __name__ == "__main__":
    main()
