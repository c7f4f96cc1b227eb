"""Draw the moving pictures of the gallery, and the same with sound: every pose set says one line.

    python docs/draw_gallery.py [--only NAME ...] [--head GLB] [FOLDER]

A pose set with a model is filmed on its own model, with its gestures. A pose set of drawings is
drawn as a simple face in two dimensions. Every other pose set has no model of its own, so its
weights move the FaceFX head: a fit over the targets of both sets finds the FaceFX poses that each
of its poses is worth. The bars always show the weights of the pose set itself. With `--head`, a
head that `lipsync-lang heads ict` made is drawn instead, as `human-head`. Needs the extras `speech`
and `video`. The pictures and films go into docs/images, or into another folder.
"""

from __future__ import annotations

import argparse
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scipy.optimize import nnls

import lipsync_lang as ll
from lipsync_lang.animations.writers.wav import write_samples
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.library import Library
from lipsync_lang.render.model.camera import framed
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.render.video import CODECS, COLOURS, REPRODUCIBLE_FLAGS, find_ffmpeg

if TYPE_CHECKING:
    from collections.abc import Iterator

LANGUAGE, TEXT = "english", "Please buy five more maps."
HEAD = "facefx"
"""Pose set whose model shows the pose sets that have neither a model nor drawings."""

FACE, BARS, FOOT, EDGE = 240, 190, 30, 8
"""Pixels: side of the face, width of the bars, height of the words, margin."""

WIDTH, HEIGHT = FACE + BARS, FACE + FOOT
FINE = 3
"""Samples per pixel and direction of drawings and text."""

FPS, QUALITY = 30, 60
STEP = 2
"""Frames of a film for each frame of a picture."""

SEEN = 0.05
"""A pose that never reaches this weight has no bar."""

HOLD = 0.02
"""Weight of the wish for small values in the fit."""

PAPER, INK, PALE, LINE, BAR = "#ffffff", "#222222", "#a3a8b0", "#e3e6ea", "#4f86c6"
SKIN, SKIN_LINE, LIP, INSIDE = "#f3c9a5", "#8a5a3c", "#b3473f", "#4a1518"
TEETH, TONGUE = "#fdfdf8", "#d9746c"


@dataclass(frozen=True)
class Mouth:
    """A drawn mouth: the size of its opening in hundredths of the face, and the content of it."""

    width: float
    height: float = 0
    upper: float = 0
    """Share of the opening that the upper teeth cover."""
    tongue: float = 0
    """Share of the opening that the tongue covers from below."""
    raised: bool = False
    """True if the tip of the tongue touches the upper teeth."""
    bite: bool = False
    """True if the upper teeth rest on the lower lip."""


REST, PRESSED = Mouth(25), Mouth(20)
WIDE, HALF = Mouth(30, 27, upper=0.2, tongue=0.35), Mouth(30, 16, upper=0.3, tongue=0.3)
CLENCHED, BITTEN = Mouth(30, 9, upper=1), Mouth(25, 7, bite=True)
LIFTED = Mouth(27, 17, upper=0.25, raised=True)
ROUND, SMALL, TINY = Mouth(19, 20, tongue=0.25), Mouth(13, 10), Mouth(9, 7)

DRAWN: dict[str, dict[str, Mouth]] = {
    "preston-blair": {
        "rest": REST, "AI": WIDE, "E": HALF, "O": ROUND, "U": SMALL, "etc": CLENCHED,
        "L": LIFTED, "WQ": TINY, "MBP": PRESSED, "FV": BITTEN,
    },
    "rhubarb": {
        "X": REST, "A": PRESSED, "B": CLENCHED, "C": HALF, "D": WIDE, "E": ROUND, "F": SMALL,
        "G": BITTEN, "H": LIFTED,
    },
    "three-mouths": {
        "mouthShut": REST, "mouthSmall": Mouth(27, 9), "mouthLarge": WIDE, "mouthRound": SMALL,
    },
}  # fmt: skip
"""A drawing of every pose, by pose set."""


# Faces


def filmed(animation: ll.Animation, times: np.ndarray) -> Iterator[Image.Image]:
    """Draw a model at times of its animation."""
    scene, swept = staged(animation), staged(sweep(animation))
    artist = Artist(scene, FACE, framed(swept), swept)
    for seconds in times:
        yield Image.fromarray(artist.draw(float(seconds - animation.times[0])))


def drawn(animation: ll.Animation, times: np.ndarray, mouths: dict[str, Mouth]) -> Iterator[Any]:
    """Draw the mouth that is shown at each time on a simple face."""
    for seconds in times:
        frame = int(np.abs(animation.times - seconds).argmin())
        weights = animation.weights[frame]
        rest = str(animation.neutral)
        yield face(mouths[animation.poses[weights.argmax()] if weights.max() > 0 else rest])


def face(mouth: Mouth) -> Image.Image:
    """Draw a face with a mouth."""
    side = FACE * FINE
    image = Image.new("RGB", (side, side), PAPER)
    draw = ImageDraw.Draw(image)
    draw.ellipse([side * at for at in (0.12, 0.05, 0.88, 0.95)], SKIN, SKIN_LINE, 2 * FINE)
    for centre in (0.36, 0.64):
        draw.ellipse([side * at for at in (centre - 0.035, 0.3, centre + 0.035, 0.4)], INK)
    nose = [side * at for at in (0.46, 0.44, 0.54, 0.52)]
    draw.arc(nose, 20, 160, SKIN_LINE, 2 * FINE)
    _mouth(image, mouth)
    return image.resize((FACE, FACE), Image.Resampling.LANCZOS)


def _mouth(image: Image.Image, mouth: Mouth) -> None:
    side, draw = FACE * FINE, ImageDraw.Draw(image)
    middle, level, lip = side / 2, side * 0.7, 4 * FINE
    across, high = mouth.width * side / 200, mouth.height * side / 200
    box = (middle - across, level - high, middle + across, level + high)
    if not mouth.height:
        bend = (middle - across, level - side * 0.03, middle + across, level + side * 0.03)
        if mouth == PRESSED:
            draw.line([(box[0], level), (box[2], level)], LIP, 3 * lip // 2)
        else:
            draw.arc(bend, 10, 170, LIP, lip)
        return
    inner = Image.new("RGB", image.size, INSIDE)
    inside = ImageDraw.Draw(inner)
    tall = 2 * high
    floor = box[3] - tall * mouth.tongue
    inside.ellipse((box[0] + across / 4, floor, box[2] - across / 4, box[3] + tall), TONGUE)
    if mouth.raised:
        tip = across / 3
        inside.ellipse((middle - tip, box[1] + tall * 0.2, middle + tip, box[3] + tall), TONGUE)
    inside.rectangle((box[0], box[1], box[2], box[1] + tall * mouth.upper), TEETH)
    if mouth.upper == 1:
        inside.line([(box[0], level), (box[2], level)], PALE, FINE)
    if mouth.bite:
        inside.rectangle((box[0], box[1], box[2], level + high * 0.3), TEETH)
        inside.rectangle((box[0], level + high * 0.3, box[2], box[3]), LIP)
    mask = Image.new("L", image.size, 0)
    ImageDraw.Draw(mask).ellipse(box, 255)
    image.paste(inner, mask=mask)
    grown = (box[0] - lip, box[1] - lip, box[2] + lip, box[3] + lip)
    draw.ellipse(grown, None, LIP, lip)


# The head that lends itself


def targets(name: str) -> dict[str, list[dict[str, float]]]:
    """Return the targets of a pose set: for each phoneme, one or two sets of weights."""
    listed = Library().poseset(name).model.targets
    return {key: [dict(part.weights) for part in parts] for key, parts in listed.items()}


def worth(name: str, poses: tuple[str, ...], others: tuple[str, ...]) -> np.ndarray:
    """Fit the poses of the head that each pose is worth, over the phonemes of both sets."""
    here, there = targets(name), targets(HEAD)
    pairs = [
        (ours, theirs)
        for key in here.keys() & there.keys()
        for ours, theirs in zip(here[key], there[key], strict=False)
        if ours and theirs
    ]
    before = np.array([[ours.get(pose, 0.0) for pose in poses] for ours, _ in pairs])
    after = np.array([[theirs.get(pose, 0.0) for pose in others] for _, theirs in pairs])
    before = np.vstack([before, HOLD * np.eye(len(poses))])
    after = np.vstack([after, np.zeros((len(poses), len(others)))])
    return np.column_stack([nnls(before, column)[0] for column in after.T])


def lent(animation: ll.Animation, name: str) -> ll.Animation:
    """Move the head by the weights of another pose set."""
    head = ll.resolve(LANGUAGE, HEAD).perform(animation.schedule, fps=animation.fps)
    gains = worth(name, animation.poses, head.poses)
    weights = np.clip(animation.weights @ gains, 0, 1)
    return replace(head, times=animation.times, weights=weights)


# Pictures


def bars(animation: ll.Animation, seconds: float) -> Image.Image:
    """Draw the weights at a time, one bar for each pose that the line uses."""
    image = Image.new("RGB", (BARS * FINE, FACE * FINE), PAPER)
    draw = ImageDraw.Draw(image)
    used = [pose for pose in animation.poses if animation[pose].max() > SEEN]
    row = min(22.0, (FACE - 2 * EDGE) / len(used))
    font = ImageFont.truetype("DejaVuSans.ttf", round(min(11.0, row * 0.82) * FINE))
    text = max(draw.textlength(pose, font) for pose in used) / FINE
    left, right, top = EDGE + text + 6, BARS - EDGE, (FACE - row * len(used)) / 2
    for number, pose in enumerate(used):
        level = top + (number + 0.5) * row
        value = float(np.interp(seconds, animation.times, animation[pose]))
        ends = [(left, right, LINE), (left, left + (right - left) * value, BAR)]
        draw.text(((left - 6) * FINE, level * FINE), pose, INK, font=font, anchor="rm")
        for begin, end, colour in ends:
            box = (begin, level - row * 0.3, end, level + row * 0.3)
            draw.rectangle([round(one * FINE) for one in box], colour)
    return image.resize((BARS, FACE), Image.Resampling.LANCZOS)


def words(schedule: ll.Schedule, seconds: float) -> Image.Image:
    """Draw the words, with the one that is said in dark."""
    image = Image.new("RGB", (WIDTH * FINE, FOOT * FINE), PAPER)
    draw = ImageDraw.Draw(image)
    font = ImageFont.truetype("DejaVuSans.ttf", 15 * FINE)
    space = draw.textlength(" ", font)
    widths = [draw.textlength(word.text, font) for word in schedule.words]
    left = (WIDTH * FINE - sum(widths) - space * (len(widths) - 1)) / 2
    for word, width in zip(schedule.words, widths, strict=True):
        now = schedule.times[word.first] <= seconds < schedule.times[word.stop]
        draw.text((left, FOOT * FINE / 2), word.text, INK if now else PALE, font, anchor="lm")
        left += width + space
    return image.resize((WIDTH, FOOT), Image.Resampling.LANCZOS)


def frames(name: str, schedule: ll.Schedule) -> tuple[float, list[Image.Image]]:
    """Draw a pose set that says the line; return the time of the first frame, and all frames."""
    performer = ll.resolve(LANGUAGE, name)
    animation = performer.perform(schedule, fps=60)
    times = np.arange(animation.times[0], animation.times[-1], 1 / FPS)
    if name in DRAWN:
        faces = drawn(animation, times, DRAWN[name])
    else:
        own = performer.perform(schedule, fps=60, gestures="all") if animation.model else None
        faces = filmed(own or lent(animation, name), times)
    pages = []
    for seconds, shown in zip(times, faces, strict=True):
        page = Image.new("RGB", (WIDTH, HEIGHT), PAPER)
        page.paste(shown, (0, 0))
        page.paste(bars(animation, seconds), (FACE, 0))
        page.paste(words(schedule, seconds), (0, FACE))
        pages.append(page)
    return float(times[0]), pages


def film(
    pages: list[Image.Image], start: float, schedule: ll.Schedule, path: Path, fps: int = FPS
) -> None:
    """Write frames from a time on, with the sound, which begins at zero seconds."""
    audio = schedule.audio
    whole = round(len(pages) / fps * audio.rate)
    samples = np.pad(audio.samples, (round(-start * audio.rate), whole))[:whole]
    width, height = pages[0].size
    with TemporaryDirectory() as folder:
        sound = Path(folder) / "sound.wav"
        with sound.open("wb") as stream:
            write_samples(samples, audio.rate, stream)
        form = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps}"]
        command = [find_ffmpeg(), "-loglevel", "error", "-y", *form, "-i", "-", "-i", str(sound)]
        command += [*COLOURS, *CODECS["mp4"], *REPRODUCIBLE_FLAGS, str(path)]
        subprocess.run(command, input=b"".join(p.tobytes() for p in pages), check=True)  # noqa: S603


def main() -> None:
    """Draw the pictures."""
    names = sorted(path.parent.name for path in built_in().glob("posesets/*/poseset.yaml"))
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent / "images")
    parser.add_argument("--only", nargs="+", choices=names, default=names)
    parser.add_argument("--head", metavar="GLB")
    options = parser.parse_args()
    schedule = ll.speak(TEXT, LANGUAGE)
    drawings = {f"gallery-{name}": name for name in options.only}
    for file, name in ({"human-head": options.head} if options.head else drawings).items():
        start, pages = frames(name, schedule)
        first, *rest = pages[::STEP]
        first.save(
            options.folder / f"{file}.webp", save_all=True, append_images=rest,
            duration=round(1000 * STEP / FPS), loop=0, quality=QUALITY, method=6,
        )  # fmt: skip
        film(pages, start, schedule, options.folder / f"{file}.mp4")


if __name__ == "__main__":
    main()
