"""Endless and oversized inputs: each reader stops with an error message."""

import gzip
import os
import threading
from contextlib import suppress
from pathlib import Path

import pytest
from lanes import full

from lipsync_lang.authoring import language_draft
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reading import MIB_BYTES, read_input
from lipsync_lang.reports.coverage import changes
from lipsync_lang.schedules import timing_file as timings
from lipsync_lang.sound.speech.sound import read_audio
from lipsync_lang.text.lines import line_readers as lines
from lipsync_lang.text.lines import read_lines
from lipsync_lang.text.phonology.g2p import lexicon

PAIR = ("-l", "english", "-c", "facefx")
LIMITS = [
    (timings, "MAX_TIMINGS_BYTES"),
    (lines, "MAX_PIPED_BYTES"),
    (lexicon, "MAX_LEXICON_BYTES"),
    (language_draft, "MAX_INVENTORY_BYTES"),
    (changes, "MAX_DOCUMENT_BYTES"),
]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Change to an empty folder, with limits of a tenth of a second instead of minutes."""
    monkeypatch.chdir(tmp_path)
    for module, name in LIMITS:
        monkeypatch.setattr(module, name, MIB_BYTES)
    return tmp_path


def told(ended, what):
    assert ended.code == 2
    assert what in ended.err, ended.err


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/urandom"])
def test_a_schedule_without_an_end_is_told(cli, device):
    ended = cli("run", *PAIR, "--schedule", device)
    told(ended, f"{device}: is larger than 1 MB; check that it is a schedule")


@pytest.fixture
def endless(folder):
    """Make an endless pipe."""
    made = []

    def make(name, block=b"moi moi\n" * 1000):
        os.mkfifo(folder / name)

        def feed():
            with suppress(BrokenPipeError), (folder / name).open("wb") as out:
                while True:
                    out.write(block)

        feeder = threading.Thread(target=feed, daemon=True)
        feeder.start()
        made.append(feeder)
        return name

    yield make
    for feeder in made:
        feeder.join(timeout=60)
        assert not feeder.is_alive(), "nobody read the pipe to its limit"


def test_a_pipe_of_timings_without_an_end_is_told(cli, endless):
    ended = cli("run", *PAIR, "--schedule", endless("line.txt"))
    told(ended, "line.txt: is larger than 1 MB; check that it is a schedule")


def test_a_script_without_an_end_is_told(cli, endless):
    told(
        cli("coverage", endless("script.txt"), *PAIR),
        "script.txt: is larger than 1 MB; put the script into a file",
    )


@full
def test_a_large_script_in_a_file_is_read_all_the_same(folder):
    (folder / "script.txt").write_bytes(b"moi\n" * MIB_BYTES)
    assert sum(1 for _ in read_lines("script.txt")) == MIB_BYTES


def test_lines_without_an_end_are_told(cli, endless, monkeypatch):
    monkeypatch.setattr("lipsync_lang.commands.output.MAX_LINES_BYTES", MIB_BYTES)
    told(
        cli("transcribe", "-l", "english", "--file", endless("a.txt")),
        "a.txt: is larger than 1 MB; give it in parts",
    )


def test_an_animation_without_an_end_is_told(cli, folder, monkeypatch):
    monkeypatch.setattr("lipsync_lang.animations.animation_readers.MAX_ANIMATION_BYTES", MIB_BYTES)
    (folder / "a.csv").symlink_to("/dev/zero")
    told(
        cli("check", *PAIR, "--animation", "a.csv"),
        "a.csv: is larger than 1 MB; check that it is an animation",
    )


def test_a_model_without_an_end_is_told(cli, folder):
    (folder / "a.glb").symlink_to("/dev/zero")
    told(cli("characters", "new", "a", "--model", "a.glb"), "a.glb: is not GLB")


def test_a_recording_through_a_pipe_or_without_an_end_is_told(endless):
    with pytest.raises(LipsyncError, match=r"a\.wav: is a pipe; write the recording to a file"):
        read_audio(endless("a.wav"))
    with pytest.raises(LipsyncError, match="not a readable recording"):
        read_audio("/dev/zero")


def test_a_lexicon_and_an_inventory_without_an_end_are_told(cli):
    told(
        cli("languages", "new", "toy", "--lexicon", "/dev/zero"),
        "/dev/zero: is larger than 1 MB; keep the words that are said",
    )
    told(
        cli("languages", "new", "toy", "--inventory", "/dev/zero"),
        "/dev/zero: is larger than 1 MB; check that it is a table of phonemes",
    )


def test_an_inventory_that_unpacks_to_any_amount_is_told(folder):
    path = folder / "bomb.csv.gz"
    path.write_bytes(gzip.compress(bytes(4 * MIB_BYTES)))
    with pytest.raises(LipsyncError, match=r"bomb\.csv\.gz: unpacks to more than 1 MB"):
        language_draft.read_inventory(path)


def test_an_older_coverage_without_an_end_is_told(cli, folder):
    (folder / "a.txt").write_text("hello\n")
    told(
        cli("coverage", "a.txt", *PAIR, "--against", "/dev/zero"),
        "/dev/zero: is larger than 1 MB; check that it is a coverage document",
    )


def test_a_pack_without_an_end_is_told(cli, folder, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_PATH", "/dev")  # the user names it; it is refused otherwise
    (folder / "languages").mkdir()
    (folder / "languages/toy.yaml").symlink_to("/dev/zero")
    ended = cli("validate", "languages/toy.yaml")
    assert ended.code == 1
    assert "P002 the file is larger than" in ended.out + ended.err


def test_a_limit_is_kept_to_the_byte():
    path = Path("a")
    path.write_bytes(b"12345")
    assert read_input(path, 5, mend="cut it") == b"12345"
    with pytest.raises(LipsyncError, match="cut it"):
        read_input(path, 4, mend="cut it")
