"""Amounts of work: calls, transactions, renames and opened files."""

import os
import sqlite3
import sys
import wave
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from build_project import PROJECT, SOUNDS, Game

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.pipeline import kernel
from lipsync_lang.production.builds import planning, records
from lipsync_lang.reports.quality.check_animation import check_all

FEW_AND_MANY = 4, 24
"""Lines of two games."""

MAX_READ_PACKS = 10
"""Maximum number of packs that an unchanged build reads; a pair has 5."""

MAX_JUDGING_CALLS = 930
"""Maximum number of calls to judge a line more of a batch on its mesh."""

MAX_PLANNING_CALLS = 400
"""Maximum number of calls for an unchanged line."""

LONG_AGO = 1_000_000_000
"""A time stamp too old to be doubted."""


# Calls of functions


def calls(act):
    """Count the calls of functions, including those in C, of the second run of an action."""
    count = 0

    def called(_frame, event, _argument):
        nonlocal count
        count += event in {"call", "c_call"}

    act()
    sys.setprofile(called)
    try:
        act()
    finally:
        sys.setprofile(None)
    return count


def line_of(count):
    labels = tuple(("M", "AA", "S", "IY0", "EL", "_")[n % 6] for n in range(count))
    return Schedule(labels, np.arange(count + 1) * 0.09, notation="arpabet")


@pytest.mark.usefixtures("arithmetic")
def test_calls_do_not_grow_with_the_phonemes_of_a_line():
    performer = ll.resolve("english", "facefx")
    lines = line_of(40), line_of(400)
    short, long = (calls(lambda line=line: performer.perform(line)) for line in lines)
    # numpy's stages look at each contact that is held
    assert long <= short + (0 if kernel.compiled is not None else 12 * 360)


@pytest.mark.usefixtures("arithmetic")
def test_calls_grow_at_most_with_the_lines_of_a_batch():
    performer = ll.resolve("english", "facefx")
    lines = [line_of(40 + n % 5) for n in range(40)]
    few = calls(lambda: performer.perform_many(lines[:10]))
    many = calls(lambda: performer.perform_many(lines))
    assert many <= 4 * few
    assert many < sum(calls(lambda one=one: performer.perform(one)) for one in lines)


@pytest.mark.skipif(kernel.compiled is None, reason="the stages in numpy take more calls")
def test_a_plain_line_more_takes_a_third_of_the_calls_of_one_alone():
    performer = ll.resolve("english", "facefx")
    lines = [Schedule(("M", "AA", "S"), np.arange(4) + n / 9) for n in range(40)]
    few, many = (calls(lambda n=n: performer.perform_many(lines[:n])) for n in (10, 40))
    assert 3 * (many - few) < 30 * calls(lambda: performer.perform(lines[0]))


def test_a_judged_line_more_takes_few_calls():
    performer = ll.resolve("english", "facefx")
    lines = performer.perform_many([line_of(40 + n % 5) for n in range(30)])
    few, many = (calls(lambda n=n: check_all(lines[:n], performer)) for n in (10, 30))
    assert many - few <= 20 * MAX_JUDGING_CALLS


def test_calls_of_a_stream_do_not_grow_with_what_was_said_before():
    performer = ll.resolve("english", "facefx")

    def played(count):
        line, stream = line_of(count), performer.stream(30, notation="arpabet")
        for label, start, end in zip(line.labels, line.times, line.times[1:], strict=False):
            stream.feed(label, start, end)
            stream.frames()

    short, middle, long = (calls(lambda n=n: played(n)) for n in (60, 120, 180))
    assert long - middle <= 1.02 * (middle - short)


# Builds


class Opened:
    """Files that this process opens while the object is active, by any function."""

    active = None

    def __init__(self):
        self.paths = []

    def __enter__(self):
        type(self).active = self.paths
        return self

    def __exit__(self, *_):
        type(self).active = None

    def below(self, folder, suffix=""):
        """Return the opened files of a folder, each as often as it was opened."""
        start = f"{folder}{os.sep}"
        return [path for path in self.paths if path.startswith(start) and path.endswith(suffix)]

    @classmethod
    def heard(cls, event, arguments):
        if (
            event == "open"
            and cls.active is not None
            and isinstance(arguments[0], str | os.PathLike)
        ):
            cls.active.append(str(Path(arguments[0]).absolute()))


@pytest.fixture(scope="module", autouse=True)
def _hook():
    """Record opened files until the process ends, since Python cannot remove the hook."""
    sys.addaudithook(Opened.heard)


class Large(Game):
    """A game with lines and recordings, in which only the first line has the bigram l-ow."""

    def __init__(self, folder, capsys, lines):
        super().__init__(folder, capsys)
        others = [sounds for name, sounds in SOUNDS.items() if name != "low"]
        names = ["low", *(f"other{n}" for n in range(1, lines))]
        for n, name in enumerate(names):
            self.say(name, others[n % len(others)] if n else SOUNDS["low"])
            with wave.open(str(folder / f"vo/{name}.wav"), "wb") as sound:
                sound.setparams((1, 2, 8000, 0, "NONE", ""))
                sound.writeframes(bytes(6400))
        self.script(names)
        self.write("lipsync.yaml", PROJECT + 'audio: "vo/{id}.wav"\n')
        for path in (folder / "vo").iterdir():
            os.utime(path, (LONG_AGO, LONG_AGO))


@pytest.fixture
def large(tmp_path, monkeypatch, capsys):
    def made(lines):
        folder = tmp_path / f"{lines}"
        folder.mkdir()
        monkeypatch.chdir(folder)
        # Tests beside this one fill the shared cache until its oldest pairs are deleted.
        monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(folder / ".cache"))
        # Files are older than the build: their times of change of status cannot be set.
        monkeypatch.setattr(planning, "TICK_NANOSECONDS", 0)
        return Large(folder, capsys, lines)

    return made


@contextmanager
def counted_writes():
    """Count transactions of the record, and renames."""
    found = {"COMMIT": 0, "rename": 0}
    connect, replace = sqlite3.connect, os.replace

    def traced(*arguments, **options):
        connection = connect(*arguments, **options)
        connection.set_trace_callback(
            lambda said: found.update(COMMIT=found["COMMIT"] + said.startswith("COMMIT"))
        )
        return connection

    def renamed(*arguments):
        found["rename"] += 1
        replace(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(records.sqlite3, "connect", traced)
        patch.setattr(os, "replace", renamed)
        yield found


def test_a_build_has_a_transaction_for_each_batch_and_a_rename_for_each_output(large):
    found = []
    for lines in (48, 96):  # in four batches
        game = large(lines)
        game.build("--dry-run")  # the pair is in the cache
        with counted_writes() as writes:
            assert len(game.build("--workers", "1").built) == lines
        found.append(writes)
    assert found[0]["COMMIT"] == found[1]["COMMIT"] <= 4 + 3, "three prepare the record"
    assert [one["rename"] for one in found] == [48, 96]


def test_an_unchanged_build_reads_no_line_and_writes_nothing(large):
    packs, counts = [], []
    for lines in FEW_AND_MANY:
        game = large(lines)
        with Opened() as opened:
            game.build()
        assert len(opened.below(game.folder / "vo", ".wav")) >= lines, "it is seen what is read"
        assert len(opened.below(game.folder / "takes")) >= lines
        with Opened() as opened, counted_writes() as writes:
            assert game.build().built == []
        assert opened.below(game.folder / "vo") == opened.below(game.folder / "takes") == []
        assert writes == {"COMMIT": 0, "rename": 0}
        packs.append(len([path for path in opened.paths if path.endswith(".yaml")]))
        counts.append(calls(game.build))
    assert packs[0] == packs[1] <= MAX_READ_PACKS
    assert counts[1] - counts[0] <= MAX_PLANNING_CALLS * (FEW_AND_MANY[1] - FEW_AND_MANY[0]), counts


def test_a_build_reads_the_timings_of_stale_lines_alone(large):
    game = large(24)
    game.build()
    game.bank(0.5)
    with Opened() as opened:
        assert game.build().built == ["low"]
    assert {Path(path).name for path in opened.below(game.folder / "vo")} == {
        "low.json",
        "low.wav",
    }
