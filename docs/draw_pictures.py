"""Draw the pictures of the documentation that show motion, into docs/images or another folder.

    python docs/draw_pictures.py [--only NAME ...] [FOLDER]

    spectrum    the share of the jaw's power above each frequency, before and now, over eight lines
    keys        keys fitted by `--keys 0.02` over every frame
    languages   each sound of a German and a Mandarin line, before and now
    crab-motion each sound of two English lines on the crab, before and now
    facefx-motion, arkit-motion   the same of three lines on these faces
    crab        bigrams of the crab as drafted and as edited, with frames
    sheet       a sheet of stills
    recording   a natural recording with its spectrogram and boundaries
    noisy       a French line as it is, with noise and with music, and with an adapted model
    styles      six styles on three faces: a vowel, and the pause after it
    takes       one sentence whispered, plain and shouted: the jaw, and the mouth in each vowel
    heard       natural recordings by their text, by the whole sound and live: the jaw

"Before" is today's targets with the motion settings of version 0.1: valleys filled, thresholds of
0.5, no softening, no look-ahead, no stress, no loudness, and every shade as its parent. Lines are
spoken by eSpeak NG; the pictures need the extras `plot` and `speech`. The recordings are of the
folder that LIPSYNC_LANG_TEST_DATA names, and need the extra `audio` as well.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image, ImageDraw, ImageFont

import lipsync_lang as ll
from lipsync_lang.animations.keys import curves
from lipsync_lang.packs.finding import built_in
from lipsync_lang.render.model.camera import close_up
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.plot import plot
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.reports.quality.curve_statistics import HIGH_HERTZ
from lipsync_lang.reports.quality.likeness import CAPTURE_FPS
from lipsync_lang.schedules.schedule import SILENCE
from lipsync_lang.sound.speech.hearing.adaptation import adapt, spoken_files, write_adapted
from lipsync_lang.sound.speech.hearing.align.pocketsphinx_aligner import models_of
from lipsync_lang.sound.speech.sound import resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker

if TYPE_CHECKING:
    from collections.abc import Sequence

ROOT = Path(__file__).parent
sys.path.insert(0, str(ROOT.parent / "benchmarks"))
import alignment  # noqa: E402 it lies beside
import hearing  # noqa: E402 it lies beside
import listening  # noqa: E402 it lies beside
import motion as benchmark  # noqa: E402 it lies beside

FRENCH = (
    "Nous partons demain matin pour la montagne.",
    "Le petit chat dort sur le canapé rouge.",
    "Elle a mangé une pomme et deux poires.",
    "Mon frère habite à Paris depuis trois ans.",
    "Il fait beau, allons nous promener au bord de la mer.",
    "Je voudrais un café et un verre d'eau.",
    "Les enfants jouent dans le jardin de la voisine.",
    "Quand est-ce que le train arrive à la gare ?",
    "Ma grand-mère prépare une soupe aux légumes.",
    "Vous avez oublié votre parapluie dans la voiture.",
    "La porte était fermée et personne ne répondait.",
    "Ce livre raconte une histoire très ancienne.",
    "Le soleil brille sur les toits de la ville.",
    "Nous avons acheté du pain et du fromage.",
    "Le médecin arrive toujours à huit heures.",
    "Demain je prépare le déjeuner avec mon père.",
)
"""A line, and others of the same voice that a model is adapted to."""

DATA = "LIPSYNC_LANG_TEST_DATA"

HEARD = (
    ("german", "German", "german"),
    ("japanese", "Japanese", "japanese"),
    ("swedish", "Swedish, not stated", "ipa:und"),
)
"""Language of a recording, title, and the language that the listener is given."""

HEARD_DELAY, HEARD_SECONDS = 0.08, 4.0

BEFORE: dict[str, Any] = {
    "smooth": "closing",
    "window": 0.1,
    "thresholds": "paper",
    "softness": 0,
    "anticipate": 0,
    "stress": 0,
    "loudness": 0,
}
"""Motion settings of version 0.1."""

CAPTURES_HIGH = (0.3, 0.5)
"""Percent of the power of captured jaws above `HIGH_HERTZ`."""

OLD, NOW, INK, PALE = "#c0392b", "#1f618d", "#222222", "#999999"
CELL, FOOT, COLUMNS = 100, 22, 12
"""Pixels: side of a still, height of a caption; and stills in a row."""

LINES = [
    ("german", "Fünf Mäuse kauften am Morgen blaue Schuhe."),
    ("mandarin", "我们明天去学校买新书。"),
]
ENGLISH = [
    ("english", "Please buy five more maps before Bob's baby puppy bumps"),
    ("english", "School. Two. Boot."),
]
SHOUT = ("english", "Fire! Get down! Everybody out, now!")

SHOWN_VOWELS = {"ay", "eh", "aw", "ah"}
"""Vowels of the takes that open the mouth."""

SEEN = 0.05
"""Difference of a pose between draft and edit that is drawn."""

TAKES = {"whisper": -20, "neutral": 0, "shout": 14}
"""Levels of the same sound in decibels, by the style of the take."""

BIGRAMS = [("ow-_", "go"), ("s-w", "sweet"), ("aw-th", "mouth")]


def pair(language: str, character: str) -> tuple[ll.Performer, ll.Performer]:
    """Return performers of a face: with the settings of before, and as it is now."""
    old = ll.resolve(language, character, shades=False).with_motion(BEFORE)
    return old, ll.resolve(language, character)


def spectrum(path: Path) -> None:
    """Draw the share of the jaw's power above each frequency, the mean of eight lines."""
    figure = Figure((7, 3.6), layout="constrained")
    axes = figure.subplots()
    for performer, colour, name in zip(
        pair("english", "facefx"), (OLD, NOW), ("before", "now"), strict=True
    ):
        shares = np.mean([_above(performer, line) for line in benchmark.lines()], axis=0)
        axes.semilogy(np.arange(len(shares)) * 0.5, shares, color=colour, lw=2, label=name)
    low, high = CAPTURES_HIGH
    axes.vlines(HIGH_HERTZ, low, high, color=INK, lw=10)
    axes.annotate(
        "captures of real faces:\n0.3-0.5 % above 8 Hz", (HIGH_HERTZ, low), (3.2, 0.25),
        arrowprops={"arrowstyle": "-", "color": PALE}, color=INK,
    )  # fmt: skip
    axes.set(
        xlim=(0, CAPTURE_FPS / 2), ylim=(0.03, 110), xlabel="frequency in Hz",
        ylabel="% of the jaw's power above it",
    )  # fmt: skip
    axes.grid(color="#dddddd", lw=0.6)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=100)


def _above(performer: ll.Performer, line: ll.Schedule) -> np.ndarray:
    """Return the percentage of a line's power above 0, 0.5, ... Hz, as `make motion` has it."""
    curve = benchmark.jaw(performer, performer.perform(line, fps=CAPTURE_FPS))
    power = np.abs(np.fft.rfft((curve - curve.mean()) * np.hanning(len(curve)))) ** 2
    hertz = np.fft.rfftfreq(len(curve), 1 / CAPTURE_FPS)
    edges = np.arange(0, CAPTURE_FPS / 2, 0.5)
    return np.array([100 * power[hertz > edge].sum() / power.sum() for edge in edges])


def fitted(path: Path) -> None:
    """Draw keys of three poses over every frame of a line."""
    performer = ll.resolve("english", "facefx")
    schedule = ll.speak("Fire! Get down! Everybody out, now!", "english")
    animation = performer.perform(schedule, fps=60).cut()
    poses = ("open", "PBM", "W")
    named = {pose: animation[pose] for pose in poses}
    table = np.column_stack([*named.values()])
    found = curves(poses, animation.times, table, 0.02, animation.contacts)
    figure = Figure((9, 4.2), layout="constrained")
    rows = figure.subplots(len(poses), sharex=True)
    seconds = float(animation.times[-1] - animation.times[0])
    for axes, curve in zip(rows, found, strict=True):
        dense, fine = named[curve.name], np.linspace(*animation.times[[0, -1]], 2000)
        axes.plot(animation.times, dense, ".", color=PALE, ms=3, label="frames")
        axes.plot(fine, _cubic(curve, fine), color=NOW, lw=1.4, label="between keys")
        axes.plot(curve.times, curve.values, "o", color=OLD, ms=5, label="keys")
        axes.set(ylabel=curve.name, ylim=(-0.08, 1.08))
        axes.set_title(f"{len(curve.times) / seconds:.1f} keys a second", loc="right", fontsize=8)
    rows[0].legend(frameon=False, ncols=3, loc="upper left", fontsize=8)
    rows[-1].set_xlabel("seconds")
    figure.savefig(path, dpi=100)


def _cubic(curve: Any, at: np.ndarray) -> np.ndarray:
    """Return the values of a fitted curve at times."""
    from scipy.interpolate import CubicHermiteSpline

    shown = np.empty(len(at))
    for number in range(len(curve.times) - 1):
        ends = slice(number, number + 2)
        slopes = [curve.leaving[number], curve.arriving[number + 1]]
        inside = (at >= curve.times[number]) & (at <= curve.times[number + 1])
        spline = CubicHermiteSpline(curve.times[ends], curve.values[ends], slopes)
        shown[inside] = spline(at[inside])
    return shown


def stills(animation: ll.Animation, seconds: Sequence[float], size: int) -> list[Image.Image]:
    """Draw the mouth at times of the schedule."""
    scene, swept = staged(animation), staged(sweep(animation))
    artist = Artist(scene, size, close_up(swept), swept)
    return [Image.fromarray(artist.draw(float(one) + scene.sound)) for one in seconds]


def languages(path: Path) -> None:
    """Draw each sound of a German and a Mandarin line, before above now."""
    _save(_beside("facefx", LINES), path)


def crab_motion(path: Path) -> None:
    """Draw each sound of two English lines on the crab, before above now."""
    _save(_beside("crab", ENGLISH), path)


def facefx_motion(path: Path) -> None:
    """Draw each sound of three English lines on the FaceFX head, before above now."""
    _save(_beside("facefx", [*ENGLISH, SHOUT]), path)


def arkit_motion(path: Path) -> None:
    """Draw each sound of three English lines on a head with ARKit's shapes, before above now."""
    head = Path(os.environ["LIPSYNC_LANG_TEST_DATA"], "rigs", "head_arkit52_oculus15.glb")
    _save(_beside(str(head), [*ENGLISH, SHOUT]), path)


def _beside(character: str, lines: Sequence[tuple[str, str]]) -> Image.Image:
    """Draw the middle of each sound of lines, given with their languages, before above now."""
    font = ImageFont.truetype("DejaVuSans.ttf", 14)
    blocks = []
    for language, text in lines:
        schedule = ll.speak(text, language)
        sounds = [n for n, label in enumerate(schedule.labels) if label != SILENCE]
        middles = ((schedule.times[:-1] + schedule.times[1:]) / 2)[sounds]
        rows = [stills(one.perform(schedule), middles, CELL) for one in pair(language, character)]
        labels = [schedule.labels[n] for n in sounds]
        for start in range(0, len(sounds), COLUMNS):
            part = slice(start, start + COLUMNS)
            blocks.append((labels[part], [row[part] for row in rows]))
    height = 2 * CELL + FOOT + 6
    page = Image.new("RGB", (COLUMNS * (CELL + 2), len(blocks) * height), "white")
    draw = ImageDraw.Draw(page)
    for number, (labels, rows) in enumerate(blocks):
        for column, label in enumerate(labels):
            left, top = column * (CELL + 2), number * height
            for row, images in enumerate(rows):
                page.paste(images[column], (left, top + row * (CELL + 2)))
            middle = (left + CELL / 2, top + 2 * CELL + 4)
            draw.text(middle, label, INK, font=font, anchor="ma")
    return page


def crab(path: Path) -> None:
    """Draw bigrams of the crab, drafted and edited: curves, and six frames of each."""
    edited = ll.resolve("english", "crab")
    with TemporaryDirectory() as folder:
        copy = Path(folder) / "posesets" / "drafted"
        shutil.copytree(built_in() / "posesets" / "crab", copy)
        shutil.rmtree(copy / "banks")
        pack = copy / "poseset.yaml"
        pack.write_text(pack.read_text("utf-8").replace("name: crab", "name: drafted"), "utf-8")
        drafted = ll.resolve("english", "drafted", paths=folder)
        figure = Figure((12.6, 7.6), layout="constrained", facecolor="#f7f4ef")
        parts = figure.subfigures(len(BIGRAMS), 1)
        for part, (bigram, word) in zip(parts, BIGRAMS, strict=True):
            _bigram(part, bigram, word, drafted, edited)
        figure.savefig(path, dpi=100)
    _save(Image.open(path).convert("RGB"), path)


def _bigram(part: Any, bigram: str, word: str, drafted: ll.Performer, edited: ll.Performer) -> None:
    schedule = ll.speak(word, "english")
    takes = [one.perform(schedule, fps=120) for one in (drafted, edited)]
    low, high = _span(edited, takes[1], bigram)
    part.set_facecolor("#f7f4ef")
    left, right = part.subfigures(1, 2, width_ratios=(1, 2.4))
    axes = left.subplots()
    inside = (takes[0].times >= low) & (takes[0].times <= high)
    moved = {p: np.abs((takes[1][p] - takes[0][p])[inside]).max() for p in edited.poses}
    colours = ("#8a6d3b", "#c0392b", "#2a8c82")
    poses = sorted((p for p in moved if moved[p] >= SEEN), key=moved.__getitem__)[-3:]
    for pose, colour in zip(poses, colours, strict=False):
        for take, style in zip(takes, ("--", "-"), strict=True):
            name = pose if style == "-" else None
            axes.plot(take.times, take[pose], style, color=colour, lw=2, label=name)
    frames = np.linspace(low, high, 8)[1:-1]
    for one in frames:
        axes.axvline(one, color="#cccccc", lw=0.8, zorder=0)
    axes.set(xlim=(low, high), ylim=(0, 1.1))
    axes.set_title(f"{bigram} in “{word}”", loc="left", fontsize=10, fontweight="bold")
    axes.legend(frameon=False, fontsize=8)
    cells = right.subplots(2, len(frames))
    for row, (take, name) in enumerate(zip(takes, ("draft", "edited"), strict=True)):
        pictures = stills(take, frames, 128)
        for column, picture in enumerate(pictures):
            cell = cells[row][column]
            cell.imshow(picture)
            cell.set(xticks=[], yticks=[])
            if row == 0:
                cell.set_title(f"{frames[column]:.2f} s", fontsize=8)
        cells[row][0].set_ylabel(name, fontweight="bold", fontsize=9)


def _span(performer: ll.Performer, animation: ll.Animation, bigram: str) -> tuple[float, float]:
    """Return the seconds of a bigram in a word."""
    names = bigram.split("-")
    ids, times, _ = performer.common_phonemes(animation.schedule)
    said = [performer.compiled.phonemes[i] for i in ids]
    parents = performer.compiled.shades
    said = [parents.get(one, one) for one in said]
    at = next(n for n in range(len(said) - 1) if said[n : n + 2] == names)
    end = times[at + 1]
    stop = end + 0.12 if names[1] == SILENCE else min(times[at + 2], end + 0.14)
    return float(max(times[at], end - 0.2)), float(stop)


def sheet(path: Path) -> None:
    """Draw a sheet of stills of a line."""
    schedule = ll.speak("Bob may buy my father a puppy.", "english")
    ll.resolve("english", "facefx").perform(schedule).save(path)
    _save(Image.open(path).convert("RGB"), path)


def styles(path: Path) -> None:
    """Draw an open vowel and a pause in six styles, on three faces; without a style at the left."""
    head = Path(os.environ["LIPSYNC_LANG_TEST_DATA"], "rigs", "head_arkit52_oculus15.glb")
    line = ll.Schedule(
        ("M", "AE", "pau", "P", "IY"), [0, 0.15, 0.45, 1.6, 1.7, 2], notation="arpabet"
    )
    font, side = ImageFont.truetype("DejaVuSans.ttf", 12), 104
    rows = []
    for character in ("facefx", str(head), "crab"):
        performer = ll.resolve("english", character)
        shown = [{}, *({style: 1.0} for style in performer.compiled.style_names)]
        for how in shown:
            animation = performer.rigged(performer.perform(line, styles=how))
            rows.append((next(iter(how), "neutral"), stills(animation, (0.3, 1.0), side)))
    page = Image.new("RGB", (7 * side, 3 * (2 * side + FOOT)), "white")
    draw = ImageDraw.Draw(page)
    for number, (style, images) in enumerate(rows):
        left, top = number % 7 * side, number // 7 * (2 * side + FOOT)
        draw.text((left + side / 2, top + 2), style, INK, font=font, anchor="ma")
        for row, image in enumerate(images):
            page.paste(image, (left, top + FOOT + row * side))
    page.quantize(160, dither=Image.Dither.NONE).save(path, optimize=True)


def recording(path: Path) -> None:
    """Draw what `--plot` shows of a sentence of LibriSpeech (CC BY 4.0)."""
    folder = Path(os.environ[DATA], "recordings", "mfa_tests")
    text = (folder / "61-70968-0000.lab").read_text("utf-8").strip()
    schedule = ll.align(folder / "61-70968-0000.flac", text.lower(), "english")
    with path.open("wb") as stream:
        plot(ll.resolve("english", "facefx").perform(schedule), stream)
    page = Image.open(path).convert("RGB")  # by the octree, for the many greys take no colour away
    page.quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(
        path, optimize=True
    )


def noisy(path: Path) -> None:
    """Draw a French line over its spectrogram, four times: its known and its found boundaries."""
    import soundfile

    line = ll.speak(FRENCH[0], "french")
    sound = resampled(line.audio, hearing.RATE)
    noise = np.random.default_rng(0).normal(size=len(sound.samples))
    music = alignment.noisy(sound, hearing.music(sound.seconds))
    with TemporaryDirectory() as name:
        folder = Path(name)
        for number, text in enumerate(FRENCH[1:]):
            said = ll.speak(text, "french").audio
            soundfile.write(folder / f"{number}.wav", said.samples, said.rate)
            (folder / f"{number}.txt").write_text(text, encoding="utf-8")
        model = folder / "adapted"
        found = adapt(Speaker.of("french"), spoken_files(folder), models_of(None))
        write_adapted(models_of(None), found.model, model)
        # The voice itself, warped to its own sound, would be right by its nature.
        own = "pocketsphinx"
        tries = {
            "as it is": (sound, own),
            "white noise, 10 dB below": (alignment.noisy(sound, noise), own),
            "music, 10 dB below": (music, own),
            f"music, model adapted to {found.lines} lines": (music, f"pocketsphinx:{model}"),
        }
        figure = Figure((9.4, 7.0), layout="constrained")
        rows = figure.subplots(len(tries), sharex=True)
        for axes, (title, (audio, aligner)) in zip(rows, tries.items(), strict=True):
            _boundaries(axes, title, line, ll.align(audio, FRENCH[0], "french", aligner=aligner))
    rows[-1].set_xlabel("seconds")
    figure.savefig(path, dpi=80)
    page = Image.open(path).convert("RGB")
    page.quantize(44, dither=Image.Dither.NONE).save(path, optimize=True)


def _boundaries(axes: Any, title: str, known: ll.Schedule, found: ll.Schedule) -> None:
    """Draw a spectrogram with the known boundaries above its middle and the found ones below."""
    audio = found.audio
    axes.specgram(
        audio.samples / 32768, NFFT=512, Fs=audio.rate, noverlap=384, cmap="Greys", vmin=-120
    )
    axes.vlines(known.times, 4000, 8000, color=NOW, lw=1.2)
    axes.vlines(found.times, 0, 4000, color="#c0392b", lw=1.2)
    for label, start, end in zip(found.labels, found.times, found.times[1:], strict=False):
        axes.text((start + end) / 2, -1300, label, ha="center", fontsize=8, color="#c0392b")
    speaker = Speaker.of("french")
    far = 1000 * np.abs([*alignment.errors(found, known, speaker)])
    figures = f"median {np.median(far):.0f} ms, 90 % {np.quantile(far, 0.9):.0f} ms"
    axes.set_title(f"{title}: {figures}", loc="left", fontsize=9, fontweight="bold")
    axes.set(ylim=(-1600, 8000), yticks=[0, 4000, 8000], yticklabels=["0", "4", "8 kHz"])


def takes(path: Path) -> None:
    """Draw a sentence in three styles and levels: its jaw, and the mouth in each vowel."""
    performer = ll.resolve("english", "facefx")
    language, text = SHOUT
    plain = ll.speak(text, language)
    ids, times, _ = performer.common_phonemes(plain)
    vowels = [i for i, one in enumerate(ids) if performer.compiled.phonemes[one] in SHOWN_VOWELS]
    middles = (times[:-1] + times[1:])[vowels] / 2
    figure = Figure((9.4, 4.4), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1, 1.9))
    curves, cells = left.subplots(len(TAKES), sharex=True), right.subplots(len(TAKES), len(vowels))
    for axes, row, (style, decibels) in zip(curves, cells, TAKES.items(), strict=True):
        samples = (plain.audio.samples * 10 ** (decibels / 20)).clip(-32768, 32767)
        sound = replace(plain.audio, samples=samples.astype(np.int16))
        styles = {} if style == "neutral" else {style: 1.0}
        take = performer.perform(replace(plain, audio=sound), styles=styles)
        axes.plot(take.times, take["open"], color=NOW)
        axes.set(ylim=(0, 1.05), ylabel="open")
        axes.set_title(f"{style}, {decibels} dB", loc="left", fontsize=9)
        for cell, picture in zip(row, stills(take, middles, CELL), strict=True):
            cell.imshow(picture)
            cell.set(xticks=[], yticks=[])
    curves[-1].set_xlabel("seconds")
    figure.savefig(path, dpi=90)
    _save(Image.open(path).convert("RGB"), path)


def heard(path: Path) -> None:
    """Draw the jaw of natural recordings by text, by the whole sound, and live at a delay."""
    natural = {one.language: one for one in hearing.natural(Path(os.environ[DATA]))}
    figure = Figure((9.4, 4.0), layout="constrained")
    columns = figure.subplots(3, len(HEARD), sharex="col", sharey=True).T
    for column, (name, title, stated) in zip(columns, HEARD, strict=True):
        one, performer = natural[name], ll.resolve(name, "facefx")
        listener = ll.resolve(stated, "facefx")
        whole = ll.recognise(one.audio, stated, recogniser="sound")
        takes = [performer.perform(ll.align(one.audio, one.text, name)), listener.perform(whole)]
        jaw = [(take.times, take["open"]) for take in takes]
        samples = listening.sound_of(one.audio)
        times, weights = listening.listened(listener, samples, HEARD_DELAY)
        jaw.append((times, weights[:, listener.poses.index("open")]))
        rows = "text", "sound, whole", f"live, {1000 * HEARD_DELAY:.0f} ms behind"
        for axes, (at, weight), row in zip(column, jaw, rows, strict=True):
            axes.fill_between(at, weight, color=NOW)
            axes.set(ylim=(0, 1.05), xlim=(0, min(HEARD_SECONDS, takes[0].times[-1])))
            axes.set_title(f"{title}: {row}" if row == "text" else row, loc="left", fontsize=9)
        column[-1].set_xlabel("seconds")
    columns[0][1].set_ylabel("open")
    figure.savefig(path, dpi=90)
    _save(Image.open(path).convert("RGB"), path)


def _save(page: Image.Image, path: Path) -> None:
    """Write a picture of 256 colours, for small files."""
    page.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)


PICTURES = {
    "spectrum": ("motion-spectrum.png", spectrum),
    "keys": ("motion-keys.png", fitted),
    "languages": ("motion-languages.png", languages),
    "crab-motion": ("motion-crab.png", crab_motion),
    "facefx-motion": ("motion-facefx.png", facefx_motion),
    "arkit-motion": ("motion-arkit.png", arkit_motion),
    "crab": ("crab-edits.png", crab),
    "sheet": ("still-sheet.png", sheet),
    "styles": ("styles.png", styles),
    "recording": ("recording.png", recording),
    "noisy": ("recording-noisy.png", noisy),
    "takes": ("loudness-takes.png", takes),
    "heard": ("heard-takes.png", heard),
}


def main() -> None:
    """Draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "images")
    parser.add_argument("--only", nargs="+", choices=PICTURES, default=[*PICTURES])
    options = parser.parse_args()
    for name in options.only:
        file, draw = PICTURES[name]
        draw(options.folder / file)


if __name__ == "__main__":
    main()
