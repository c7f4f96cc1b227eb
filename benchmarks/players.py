"""Time of a frame in the C player, and sizes of an hour as takes, CSV and GLB.

    python benchmarks/players.py

Lines of the tutorial's language are timed by estimate, on a face that has a model. The C program
is compiled with `cc -O2`; a frame is 1/60 s, and each character plays line after line.
"""

import subprocess
import sys
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

import lipsync_lang as ll
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.plugins.players.takes import Archive, Player
from lipsync_lang.production.builds.takes import write_takes

CHARACTERS = 1000
RUNS = 9
SENTENCES = (
    "Glue the sheet to the dark blue background.",
    "It is easy to tell the depth of a well.",
    "These days a chicken leg is a rare dish.",
    "Rice is often served in round bowls.",
    "The juice of lemons makes fine punch.",
    "The box was thrown beside the parked truck.",
    "Four hours of steady work faced us.",
    "A large size in stockings is hard to sell.",
)


def main() -> None:
    """Print the figures."""
    language, character = (sys.argv[1:] + ["english", "facefx"][len(sys.argv) - 1 :])[:2]
    performer = ll.resolve(language, character)
    lines = [performer.perform(ll.speak(text, language, engine="none")) for text in SENTENCES]
    seconds = sum(float(line.times[-1] - line.times[0]) for line in lines)
    sizes = {}
    for name in ("player", "csv", "glb"):
        streams = [BytesIO() for _ in lines]
        for line, out in zip(lines, streams, strict=True):
            WRITERS[name].write(performer.rigged(line) if name == "glb" else line, out)
        sizes[name] = [out.getvalue() for out in streams]
    moving = sum(bool(one.any()) for line in lines for one in line.weights.T) / len(lines)
    with TemporaryDirectory() as folder:
        path = Path(folder, "a.takes")
        names = [f"en/{number}" for number in range(len(lines))]
        write_takes(path, dict(zip(names, sizes["player"], strict=True)))
        each = path.stat().st_size / seconds
        print(f"takes: {each / moving:.1f} bytes a second and moving pose ({moving:.1f} poses)")
        print(f"an hour: takes {each * 3600 / 1e6:.2f} MB", end="")
        for name in ("csv", "glb"):
            print(f", {name} {sum(map(len, sizes[name])) / seconds * 3600 / 1e6:.1f} MB", end="")
        print()
        began = perf_counter()
        with Archive(path) as archive:
            player = Player(archive)
            for name in names:
                player.play(name)
                while player.playing:
                    player.advance(1 / 60)
        frames = seconds * 60
        print(f"Python: {(perf_counter() - began) / frames * 1e6:.0f} us a character and frame")
        program = Path(folder, "players")
        header = Path(ll.__file__).parent / "plugins/players"
        source = Path(__file__).with_suffix(".c")
        made = ["cc", "-O2", "-std=c11", f"-I{header}", str(source), "-o", str(program)]
        subprocess.run(made, check=True)  # noqa: S603 a compiler of our own
        command = [str(program), str(path), str(CHARACTERS), *names]
        runs = []
        for _ in range(RUNS):
            told = subprocess.run(command, check=True, capture_output=True, text=True).stdout  # noqa: S603
            runs.append([float(one) for one in told.split()])
        first, mean = np.median(runs, axis=0)
        print(
            f"C, {CHARACTERS:,} characters: {first:.2f} ms for the frame when all begin, ", end=""
        )
        print(f"{mean:.2f} ms a frame afterwards; medians of {RUNS} runs")


if __name__ == "__main__":
    main()
