"""A small project to build: lines with timings, whose phonemes are known."""

import json
from pathlib import Path

from lipsync_lang.base.files.temporary import temporary_name, this_process
from lipsync_lang.cli import main

PROJECT = """\
kind: project
format: 1
language: english
character: facefx
fps: 30
lines: script.csv
timings: "vo/{id}.json"
outputs: ["takes/{id}.csv"]
"""

SOUNDS = {
    "low": "L OW",
    "map": "M AE P",
    "mail": "M EY L",
    "home": "HH OW M",
}
"""Lines by id, as ARPAbet."""

BANK = """\
kind: bank
format: 1
name: common
poseset: facefx
bigrams:
  l-ow:
    curves: {{open: [[0, 0], [0.5, {level}], [1, 0]]}}
"""


DEAD = 4194305
"""Number of an impossible process: too large."""


def left_behind(folder, name="x.csv"):
    """Write a temporary file as a killed process of this machine leaves it."""
    folder.mkdir(parents=True, exist_ok=True)
    machine = this_process().partition("-")[0]
    path = folder / temporary_name(name, f"{machine}-{DEAD}")
    path.write_bytes(b"half")
    return path


class Game:
    """A project in a folder, and the command that builds it."""

    def __init__(self, folder: Path, capsys):
        self.folder = folder
        self.capsys = capsys
        (folder / "vo").mkdir()
        for name, labels in SOUNDS.items():
            self.say(name, labels)
        self.write("lipsync.yaml", PROJECT)
        self.script(SOUNDS)

    def write(self, path, text):
        """Write a file of the project."""
        (self.folder / path).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / path).write_text(text, encoding="utf-8")

    def script(self, names):
        """Write the table with these lines."""
        self.write("script.csv", "id,text\n" + "".join(f"{name},{name}\n" for name in names))

    def say(self, name, labels):
        """Write the timings of a line, a tenth of a second for each phoneme."""
        labels = labels.split()
        phonemes = [
            {"label": label, "start": at / 10, "end": (at + 1) / 10}
            for at, label in enumerate(labels)
        ]
        self.write(f"vo/{name}.json", json.dumps({"notation": "arpabet", "phonemes": phonemes}))

    def bank(self, level):
        """Draw the bigram l-ow in a bank of the project."""
        self.write("posesets/facefx/banks/common.yaml", BANK.format(level=level))

    def build(self, *options):
        """Build, and return the exit code, the events by name, and the text on stderr."""
        code = main(["build", "--json", *options])
        out, err = self.capsys.readouterr()
        events = [json.loads(line) for line in out.splitlines()]
        return Told(code, events, err)

    def takes(self):
        """Return the outputs by name."""
        return {path.stem: path.read_bytes() for path in (self.folder / "takes").rglob("*.csv")}


class Told:
    """The events of a build."""

    def __init__(self, code, events, err):
        self.code, self.events, self.err = code, events, err

    @property
    def built(self):
        """Ids of the lines that were made."""
        return sorted(e["name"] for e in self.events if e.get("outcome") == "built")

    @property
    def stale(self):
        """Ids of the lines that would be made, with their reasons."""
        return {e["name"]: e["reasons"] for e in self.events if e["event"] == "stale"}

    @property
    def end(self):
        """The last event."""
        (end,) = (e for e in self.events if e["event"] == "end")
        return end


SAID = ["L OW", "M AE P", "M EY L", "HH OW M", "L OW M", "M AE M", "P AE L"]
ARCHIVE = "takes/facefx.takes"


def archived_game(folder, capsys):
    """Return a game of seven lines whose takes are in an archive."""
    made = Game(folder, capsys)
    for number, sounds in enumerate(SAID):
        made.say(f"line{number}", sounds)
    made.script([f"line{number}" for number in range(len(SAID))])
    stated = PROJECT.replace('"takes/{id}.csv"', '"takes/{character}.takes", "csv/{id}.csv"')
    made.write("lipsync.yaml", stated)
    return made
