"""A project to build, of as many lines as are asked for, and the command that builds it."""

import json
import shutil
import tempfile
import time
import wave
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from speed_table import Ended, command, run, say

import lipsync_lang as ll

LABELS = "AA AE AH AO EH IH IY UW B D F G HH K L M N P R S T V W Z TH SH".split()  # noqa: SIM905 readable
"""Sounds of the lines; the edited bigram is of none of them."""

WORDS = (  # noqa: SIM905 readable
    "the a old young dark bright river garden window captain morning people money bread carries "
    "opens follows under over before after slowly never always seven twenty big small please buy "
    "more maps away moves Bob Anna home tomorrow"
).split()

PHONEMES = 40
"""Phonemes of a timed line."""

EDITED = 50
"""Lines that contain the edited bigram."""

TELL_SECONDS = 10.0
"""Pause between two messages of progress."""

PROJECT = """\
kind: project
format: 1
language: english
character: facefx
lines: script.csv
{timed}
outputs: [{outputs}]
"""

TIMED_BY = {
    "timings": 'timings: "vo/{id}.txt"',
    "recordings": 'audio: "vo/{id}.wav"\nrecordings: required',
    "a voice": "",
}
"""Fields of a project, by what times its lines."""

RECORDED = 40
"""Recordings of a project of aligned lines: its lines say the same texts again and again."""

BANK = """\
kind: bank
format: 1
name: common
poseset: facefx
bigrams:
  l-oy:
    curves: {{open: [[0, 0], [0.5, {level}], [1, 0]]}}
"""


class BuildError(Exception):
    """A build did not make the lines it should."""


class BuildRun(NamedTuple):
    """A finished build."""

    ended: Ended
    rate: float
    """Lines a second once it makes lines; 0 if it made none."""


def steady_rate(events: Sequence[tuple[float, int]]) -> float:
    """Return the slope of lines over seconds, fitted to the progress of a build."""
    if len(events) < 3:
        return events[-1][1] / events[-1][0] if events else 0.0
    return float(np.polyfit(*zip(*events, strict=True), 1)[0])


class Script:
    """A project of lines in a folder, and the command that builds it."""

    def __init__(
        self, folder: Path, lines: int, outputs: Sequence[str], *, by: str = "timings"
    ) -> None:
        self.folder, self.lines, self.outputs = folder, lines, tuple(outputs)
        (folder / "vo").mkdir(parents=True)
        paths = ", ".join(f'"{one}/{{id}}.{one}"' for one in outputs)
        (folder / "lipsync.yaml").write_text(
            PROJECT.format(outputs=paths, timed=TIMED_BY[by]), "utf-8"
        )
        chance = np.random.default_rng(1)
        rows, said = ["id,text"], list[str]()
        for number in range(lines):
            if by != "recordings" or number < RECORDED:
                said.append(_text(chance, number))
            text = said[number % RECORDED if by == "recordings" else -1]
            rows.append(f"l{number:05},{text}")
            if by == "timings":
                part, rest = divmod(number, max(1, lines // EDITED))
                edited = rest == 0 and part < EDITED
                timings = _timings(chance, edited=edited)
                (folder / f"vo/l{number:05}.txt").write_text(timings, "utf-8")
        (folder / "script.csv").write_text("\n".join(rows) + "\n", "utf-8")
        if by == "recordings":
            _record(folder / "vo", lines, said)

    def clear(self) -> None:
        """Delete what builds have made."""
        for name in (*self.outputs, ".lipsync_lang"):
            shutil.rmtree(self.folder / name, ignore_errors=True)

    def edit(self, level: float) -> None:
        """Draw the edited bigram in a bank of the project."""
        bank = self.folder / "posesets/facefx/banks/common.yaml"
        bank.parent.mkdir(parents=True, exist_ok=True)
        bank.write_text(BANK.format(level=level), "utf-8")

    def build(self, *options: str, expected: int) -> BuildRun:
        """Build, tell the progress, and see that as many lines as expected were made."""
        since, failed, events = time.monotonic(), list[str](), list[tuple[float, int]]()
        made = 0

        def told(line: str) -> None:
            nonlocal made, since
            event = json.loads(line)
            made += event.get("outcome") == "built"
            if event.get("outcome") == "failed":
                failed.append(event["message"])
            if event["event"] == "progress":
                events.append((event["seconds"], event["done"]))
                if time.monotonic() - since > TELL_SECONDS:
                    since = time.monotonic()
                    say(f"{event['done']:,} of {event['of']:,} lines in {event['seconds']:.0f} s")

        ended = run(command("build", "--json", *options), folder=self.folder, told=told)
        if ended.code or made != expected:
            raise BuildError(f"{made} lines of {expected} were made: {failed[:1]} {ended.error}")
        return BuildRun(ended, steady_rate(events))

    def kilobytes(self, name: str, size: Callable[[Path], int]) -> float:
        """Return the size of a file or of the files of a folder, in kB for each line."""
        found = self.folder / name
        return sum(map(size, found.iterdir() if found.is_dir() else [found])) / self.lines / 1e3


def _record(folder: Path, lines: int, texts: Sequence[str]) -> None:
    """Let a voice speak each text once, and give each line a recording that no other has."""
    spoken = [one.audio for one in ll.speak(texts, "english")]
    for number in range(lines):
        audio = spoken[number % len(texts)]
        # a little longer each time: equal recordings would be aligned once
        silence = np.zeros(number // len(texts), np.int16)
        with wave.open(str(folder / f"l{number:05}.wav"), "wb") as file:
            file.setparams((1, 2, audio.rate, 0, "NONE", ""))
            file.writeframes(np.concatenate((audio.samples, silence)).tobytes())


def _text(chance: np.random.Generator, number: int) -> str:
    """Return a sentence that no other line has."""
    return f"{' '.join(chance.choice(WORDS, 8))} {number}"


def _timings(chance: np.random.Generator, *, edited: bool) -> str:
    """Return timed phonemes as tab-separated labels."""
    times = np.concatenate(([0.0], np.cumsum(chance.uniform(0.04, 0.12, PHONEMES))))
    labels = chance.choice(LABELS, PHONEMES).tolist()
    if edited:
        labels[10:12] = ["L", "OY"]
    rows = zip(times, times[1:], labels, strict=False)
    return "".join(f"{start:.4f}\t{end:.4f}\t{label}\n" for start, end, label in rows)


@contextmanager
def script(lines: int, outputs: Sequence[str], *, by: str = "timings") -> Iterator[Script]:
    """Make a project of so many lines, whose packs are in the cache."""
    with tempfile.TemporaryDirectory() as folder:
        made = Script(Path(folder) / "project", lines, outputs, by=by)
        run(command("build", "--dry-run"), folder=made.folder)
        yield made
