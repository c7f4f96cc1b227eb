"""`run` and `explain`: outputs, options that reach them, and refusals."""

import csv
import json
import os
import re
import shutil
import wave
from pathlib import Path

import numpy as np
import pytest
from command_line import PAIR, ROWS, SCHEDULE, listed, refused
from lanes import full, needs_espeak, needs_plug_ins

from lipsync_lang.base import extras

pytestmark = pytest.mark.usefixtures("folder")


def test_run_writes_every_format_and_says_so(animate, folder):
    ended = animate("-o", "a.csv", "-o", "b.json", "--fps", "30")
    assert (ended.code, ended.out) == (0, "")
    assert ended.err == (
        "4 phonemes, 1 word, -0.23 to 0.73 s, 30 frames of 9 poses at 30 fps\n"
        "wrote a.csv\nwrote b.json\n"
    )
    assert listed(folder) == {"a.csv", "b.json"}
    rows = list(csv.DictReader((folder / "a.csv").read_text("utf-8").splitlines()))
    assert len(rows) == len(json.loads((folder / "b.json").read_bytes())["frames"]) == 30


def test_run_names_a_pack_that_stands_in_place_of_a_built_in_one(animate, folder, root):
    assert "in place of" not in animate("-o", "a.csv").err
    shutil.copytree(root / "posesets" / "facefx", folder / "posesets" / "facefx")
    ended = animate("-o", "a.csv")
    own = Path("posesets", "facefx", "poseset.yaml")
    assert ended.err.count(f"{own} replaces the built-in pack of the same name") == 1


def test_run_without_outputs_says_how_to_name_one(animate, folder):
    ended = animate()
    assert (ended.code, ended.out) == (0, "")
    assert "no file was written; name files with -o" in ended.err
    assert listed(folder) == set()


def test_a_textgrid_gives_the_same_curves_as_json(animate, cli, folder):
    animate("-o", "a.csv")
    assert cli("run", *PAIR, "--schedule", "line.TextGrid", "-o", "b.csv").code == 0
    assert (folder / "a.csv").read_bytes() == (folder / "b.csv").read_bytes()


def test_what_a_schedule_does_not_say_is_said_for_it(animate, cli, folder):
    rows = [f"{label},{start * 1e4:g},{end * 1e4:g},Ann" for label, start, end in ROWS]
    text = "\n".join(["label,start,end,speaker", *rows, "M,0,5000,Bob"])
    (folder / "line.odd").write_text(text, "cp037")
    told = ("--encoding", "cp037", "--tier", "Ann", "--rate", "10000")
    assert cli("run", *PAIR, "--schedule", "line.odd", *told, "-o", "b.csv").code == 0
    animate("-o", "a.csv")
    assert (folder / "a.csv").read_bytes() == (folder / "b.csv").read_bytes()


def test_a_channel_of_a_recording_is_chosen(animate, folder):
    soundfile = pytest.importorskip("soundfile", reason="the extra `audio` is not installed")
    both = np.stack([np.full(9600, 1000), np.full(9600, 3000)], axis=1).astype(np.int16)
    soundfile.write(folder / "two.wav", both, 16_000)

    def loudest(*options):
        assert animate("--audio", "two.wav", "-o", "a.wav", *options).code == 0
        return soundfile.read(folder / "a.wav", dtype="int16")[0].max()

    assert loudest() == 2000
    assert loudest("--audio-channel", "2") == 3000
    ended = animate("--audio", "two.wav", "--audio-channel", "3")
    refused(ended, "two.wav: has no channel 3; its channels are numbered 1 to 2")
    refused(animate("--audio-channel", "1"), "--audio-channel needs a recording; give one with")


@needs_plug_ins
def test_an_offset_and_the_error_of_keys_reach_the_files(animate, folder):
    def keys(*rest):
        assert animate("-o", "a.bml", *rest).code == 0
        return sum(map(int, re.findall('num_keys="([0-9]+)"', (folder / "a.bml").read_text())))

    assert keys("--keys", "lines:0") > keys() > keys("--keys", "lines:0.3")
    assert keys("--keys", "lines:0.05") == keys("--keys", "0.05")
    assert animate("--fps", "24", "--offset", "00:00:10:12", "-o", "a.csv", "--cut").code == 0
    rows = list(csv.DictReader((folder / "a.csv").read_text("utf-8").splitlines()))
    assert float(rows[0]["time_s"]) == 10.5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--keys", "lines:1"), "--keys lines:1: give the largest error of keys"),
        (("--keys", "lines:nan"), "or that of straight lines, from 0"),
        (("--keys", "line:0.1"), "--keys line:0.1: give the largest error"),
        (("--offset", "nan"), "--offset nan: a timeline lasts at most one day"),
        (("--offset", "01:00:00:00", "--fps", "inf"), "inf frames per second: give a number"),
        (("--plot", "a"), "the picture's name has no suffix; known: png"),
        (("-o", "csv:a.png", "--plot", "a.png"), "a.png: is also an output"),
    ],
)
def test_numbers_and_files_that_make_no_sense_are_told(options, message, animate):
    refused(animate(*options), message)


def test_poses_are_written_in_the_place_of_a_rigs_channels(cli, folder):
    (folder / "characters").mkdir()
    text = "kind: character\nformat: 1\nname: max\nposeset: facefx\nrig: facefx-to-arkit\n"
    (folder / "characters" / "max.yaml").write_text(text, "utf-8")
    line = ("run", "-l", "english", "-c", "max", "--schedule", "line.json")
    assert cli(*line, "-o", "a.csv").code == cli(*line, "-o", "b.csv", "--poses").code == 0
    assert "jawOpen" in (folder / "a.csv").read_text("utf-8").split("\n")[0]
    assert (folder / "b.csv").read_text("utf-8").startswith("time_s,open,W,ShCh,")


def test_an_animation_can_be_performed_again(animate, cli, folder):
    animate("-o", "a.json", "-o", "a.csv")
    assert cli("run", *PAIR, "--schedule", "a.json", "-o", "b.json", "-o", "b.csv").code == 0
    assert (folder / "a.json").read_bytes() == (folder / "b.json").read_bytes()
    assert (folder / "a.csv").read_bytes() == (folder / "b.csv").read_bytes()


def test_cut_leaves_out_lead_in_and_tail(animate, folder):
    ended = animate("-o", "a.csv", "-o", "b.json", "--cut")
    assert ended.code == 0
    rows = list(csv.DictReader((folder / "a.csv").read_text("utf-8").splitlines()))
    assert (float(rows[0]["time_s"]), float(rows[-1]["time_s"])) == (0, 0.5)
    assert json.loads((folder / "b.json").read_bytes())["start"] == 0
    assert "0.00 to 0.50 s, 31 frames" in ended.err, "what is told is what is written"


@needs_espeak
def test_text_is_spoken_and_its_sound_written(cli, folder):
    ended = cli("run", "Hello, world", *PAIR, "-o", "hello.wav", "-o", "hello.json")
    assert ended.code == 0
    assert "2 words" in ended.err
    with wave.open(str(folder / "hello.wav")) as sound:
        assert sound.getnframes() > sound.getframerate() / 2
    words = json.loads((folder / "hello.json").read_bytes())["words"]
    assert [word["text"] for word in words] == ["Hello", "world"]


@pytest.mark.parametrize(
    ("settings_", "changes"),
    [
        (["motion=paper"], True),
        (["motion=default"], False),
        (["motion.softness=0"], True),
        (["motion.softness=1"], False),
        (["motion.window=0.01"], False),  # no valley is filled
        (["motion.smooth=closing", "motion.window=0.2"], True),
        (["motion=paper", "motion.window=0.01"], True),
        (["motion.speed_limit=5"], True),
        (["motion.warp=linear"], True),
    ],
    ids=str,
)
def test_motion_is_set(settings_, changes, animate, folder):
    animate("-o", "a.csv")
    ended = animate(*(part for s in settings_ for part in ("--set", s)), "-o", "b.csv")
    assert ended.code == 0
    same = (folder / "a.csv").read_bytes() == (folder / "b.csv").read_bytes()
    assert same != changes


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("motion=papr", "unknown motion preset 'papr'; did you mean 'paper'"),
        ("motion=", "unknown motion preset ''; known: default, paper"),
        ("motion", "write motion.NAME=VALUE .--set motion.window=0.1. or motion=PRESET"),
        ("window=1", "--set window=1: write motion.NAME=VALUE"),
        ("motion.windw=1", "unknown motion setting 'windw'; did you mean 'window'"),
        ("motion.=1", "unknown motion setting ''; known: anticipate, contacts, ends, hold"),
        ("motion.window=", "motion.window is ''; it is a number from 0 to 10, as 0.1"),
        ("motion.window=wide", "motion.window is 'wide'; it is a number"),
        ("motion.window=-1", "motion.window is '-1'; it is a number"),
        ("motion.window=nan", "motion.window is 'nan'; it is a number"),
        ("motion.window=1e9", "motion.window is '1e9'; it is a number from 0 to 10"),
        ("motion.silence_reach=inf", "motion.silence_reach is 'inf'; it is a number"),
        ("motion.speed_limit=0", "motion.speed_limit is '0'; it is a number from 1 to 1e.06"),
        ("motion.smooth=fully", "motion.smooth is 'fully'; it is one of closing, chord, none"),
    ],
)
def test_motion_that_cannot_be_set_is_told(setting, message, animate):
    refused(animate("--set", setting), message)


@pytest.mark.parametrize("fps", ["0", "-1", "nan", "inf", "1e9", "0.5"])
def test_rates_nobody_plays_are_refused(fps, animate):
    refused(animate("--fps", fps), "frames per second: give a number from 1 to 1000")


@pytest.mark.parametrize("fps", ["1", "12", "23.976", "1000"])
def test_rates_somebody_plays_are_taken(fps, animate):
    assert animate("--fps", fps).code == 0


def test_a_rate_that_is_no_number_is_refused(animate):
    refused(animate("--fps", "fast"), "--fps fast: write a number of frames per second")


@pytest.mark.parametrize("command", [["run"], ["explain", "--at", "0"]])
@pytest.mark.parametrize("source", [[], ["hello", "--schedule", "line.json"]])
def test_text_or_schedule_and_not_both(command, source, cli):
    refused(cli(*command, *PAIR, *source), "give a TEXT to speak, timed phonemes with --sched")


def test_options_that_would_do_nothing_are_refused(animate, cli):
    refused(animate("--tts", "espeak"), "--tts speaks a TEXT; leave it out")
    refused(cli("run", "hi", *PAIR, "--notation", "ipa"), "--notation .* leave it out")


@pytest.mark.parametrize(
    ("outputs", "message"),
    [
        (["a"], "^lipsync-lang: a: has no suffix; use one of .*\\.csv, "),
        (["."], "has no suffix"),
        (["a.cvs"], "a.cvs: no writer for '.cvs'; use one of .*\\.csv, "),
        (["a.csv", "nowhere/b.csv"], "nowhere/b.csv: the folder nowhere does not exist; make it"),
        (["a.csv", "b.csv/c.csv"], "b.csv/c.csv: the folder b.csv does not exist"),
        (["a.csv", "line.TextGrid/b.csv"], "line.TextGrid/b.csv: cannot be written: Not a dir"),
        (["a.csv", "a.csv"], "a.csv: is also an output; name another file"),
        (["a.csv", "./b/../a.csv"], "a.csv: is also an output"),
        (["a.csv", "line.json"], "line.json: is also the input schedule; name another file"),
        (["a.csv", "b.wav"], "no sound to write: line.json has no audio; speak text"),
        (["a.csv", "x" * 300 + ".csv"], "xxx.csv: cannot be written: File name too long"),
    ],
)
def test_several_outputs_are_written_all_or_none(outputs, message, animate, folder):
    refused(animate(*(part for name in outputs for part in ("-o", name))), message)
    assert listed(folder) == set()
    refused(animate(*(part for name in outputs[::-1] for part in ("-o", name))), message)
    assert listed(folder) == set()
    assert json.loads((folder / "line.json").read_bytes()) == SCHEDULE


def test_a_folder_in_the_place_of_an_output_stays(animate, folder):
    (folder / "b.csv").mkdir()
    refused(animate("-o", "a.csv", "-o", "b.csv"), "b.csv: is a folder; name a file in it")
    assert listed(folder) == {"b.csv"}


def test_a_picture_is_an_output_like_the_others(animate, folder):
    refused(animate("-o", "a.csv", "--plot", "a.csv"), "a.csv: is also an output")
    refused(animate("-o", "a.csv", "--plot", "a.txt"), "a.txt|txt")
    assert listed(folder) == set()


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="as root every folder can be written to"
)
def test_a_read_only_folder_is_told(animate, folder):
    (folder / "closed").mkdir(mode=0o500)
    refused(animate("-o", "a.csv", "-o", "closed/b.csv"), "closed/b.csv: cannot be written")
    assert listed(folder) == {"closed"}


def test_what_was_there_stays_when_writing_fails(animate, folder):
    (folder / "a.csv").write_text("precious")
    refused(animate("-o", "a.csv", "-o", "b.wav"), "no sound")
    assert (folder / "a.csv").read_text() == "precious"
    assert animate("-o", "a.csv").code == 0
    assert (folder / "a.csv").read_text().startswith("time_s,")


@full
def test_a_notation_is_named_or_recognised(animate, folder):
    assert animate("--notation", "arpabet", "-o", "a.csv").code == 0
    assert animate("-o", "b.csv").code == 0
    assert (folder / "a.csv").read_bytes() == (folder / "b.csv").read_bytes()
    refused(animate("--notation", "arpabt"), "english has no notation 'arpabt'; did you mean 'arpa")


def test_unknown_labels_are_an_error_or_rest(cli, folder):
    rows = [{"label": "HH", "start": 0, "end": 0.1}, {"label": "QZ", "start": 0.1, "end": 0.2}]
    (folder / "odd.json").write_text(json.dumps(rows))
    command = ("run", *PAIR, "--schedule", "odd.json", "--notation", "arpabet", "-o", "a.csv")
    refused(cli(*command), r"odd.json: phoneme 1 \('QZ', 0.1 to 0.2 s\) .*\n.*\(--unknown rest\)")
    assert cli(*command, "--unknown", "rest").code == 0


def test_a_line_nobody_edited_is_told(animate):
    refused(animate("--line", "intro_042"), "facefx has no edits for line 'intro_042'")


def test_explain_tells_of_a_frame(cli):
    ended = cli("explain", *PAIR, "--schedule", "line.json", "--at", "0.2")
    assert (ended.code, ended.err) == (0, "")
    assert re.match(r"0.200 s \(frame \d+\): L as l, 0.150 to 0.250 s, in 'hello'\n", ended.out)
    assert re.search(r"poseset.yaml:\d+:\d+", ended.out)
    ended = cli("explain", *PAIR, "--schedule", "line.json", "--at", "0.2", "--json")
    assert json.loads(ended.out)["common"] == "l"


@pytest.mark.parametrize("at", ["-9", "9", "nan", "inf"])
def test_explain_refuses_times_outside(at, cli):
    ended = cli("explain", *PAIR, "--schedule", "line.json", f"--at={at}")
    refused(ended, "s is outside the animation, which runs from -0.250 to 0.750 s")


def test_extras_that_a_line_and_its_files_lack_are_named_together(cli, monkeypatch):
    monkeypatch.setattr(extras, "importable", lambda _: False)
    ended = cli("run", "x", "-l", "mandarin", "-c", "facefx", "-o", "a.mp4", "--plot", "p.png")
    assert ended.code == 2
    told = "video (for a.mp4), plot (for p.png), mandarin (for mandarin), speech (for mandarin)"
    assert f"not installed: {told}" in ended.err
    assert '"lipsync-lang[mandarin,plot,speech,video]"' in ended.err
    heard = cli("check", "x", *PAIR, "--audio", "a.wav").err
    assert '"lipsync-lang[audio,speech]"' in heard
