"""The command line: data on stdout, messages on stderr, and exit codes 0, 1 and 2."""

import csv
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import wave
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from lanes import costly, full, swept

from lipsync_lang.cli import main, parser
from lipsync_lang.pipeline import kernel
from lipsync_lang.version import __version__

try:
    import espeakng_loader
except ImportError:
    espeakng_loader = None
needs_espeak = pytest.mark.skipif(espeakng_loader is None, reason="needs espeakng_loader")

PAIR = ("-l", "english", "-c", "facefx")
ROWS = [("HH", 0, 0.08), ("AH0", 0.08, 0.15), ("L", 0.15, 0.25), ("OW1", 0.25, 0.5)]
SCHEDULE = {
    "phonemes": [{"label": p, "start": a, "end": b} for p, a, b in ROWS],
    "words": [{"text": "hello", "start": 0, "end": 0.5}],
}
TEXTGRID = """\
File type = "ooTextFile"
Object class = "TextGrid"

0
0.5
<exists>
1
"IntervalTier"
"phones"
0
0.5
4
""" + "".join(f'{start}\n{end}\n"{label}"\n' for label, start, end in ROWS)


def actions(made):
    """List the actions of a parser."""
    return made._actions  # noqa: SLF001 it tells no other way


def commands(made, *names):
    """Yield the words and the parser of every command and action."""
    for action in actions(made):
        if isinstance(action.choices, dict):
            for name, inner in action.choices.items():
                yield (*names, name), inner
                yield from commands(inner, *names, name)


COMMANDS = dict(commands(parser()))
assert COMMANDS, "a sweep over nothing passes"
every_command = pytest.mark.parametrize("words", COMMANDS, ids=" ".join)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Change to a folder with two schedules."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.json").write_text(json.dumps(SCHEDULE), "utf-8")
    (tmp_path / "line.TextGrid").write_text(TEXTGRID, "utf-8")
    return tmp_path


@pytest.fixture
def animate(cli):
    """Run `run` on the schedule."""

    def run(*rest):
        return cli("run", *PAIR, "--schedule", "line.json", *rest)

    return run


def refused(ended, message, code=2):
    assert ended.code == code
    assert ended.out == ""
    assert re.search(message, ended.err), ended.err


def listed(folder):
    return {p.name for p in folder.iterdir()} - {"line.json", "line.TextGrid"}


# Help


@every_command
def test_every_command_has_help_with_an_example_that_can_be_parsed(words, cli):
    ended = cli(*words, "--help")
    assert ended.code == 0
    found = re.search(r"^  lipsync-lang (.+)$", ended.out, re.MULTILINE)
    assert found, "no example"
    example_ = shlex.split(found[1].partition(" > ")[0])
    parser().parse_args(example_)
    assert example_[0] == words[0]


@every_command
def test_every_option_says_what_it_does(words):
    for action in actions(COMMANDS[words]):
        named = action.option_strings or [action.dest]
        told = action.help or action.choices
        assert told, f"{' '.join(words)} {named[0]} says nothing"


@every_command
def test_every_command_is_in_the_reference(words, root):
    text = (root / "docs" / "reference" / "commands.md").read_text("utf-8")
    assert re.search(rf"lipsync-lang {' '.join(words)}\b", text), (
        "not in docs/reference/commands.md"
    )


@every_command
def test_every_option_is_in_the_reference(words, root):
    text = (root / "docs" / "reference" / "commands.md").read_text("utf-8")
    options = {o for a in actions(COMMANDS[words]) for o in a.option_strings if o[:2] == "--"}
    missing = {option for option in options if not re.search(rf"{option}\b", text)}
    assert not missing - {"--help"}


def test_the_version_is_printed(cli):
    assert cli("--version").out == f"lipsync-lang {__version__} ({kernel.summary()})\n"


@pytest.mark.parametrize("arguments", [["dance"], ["bank"], ["run", "--fps"]])
def test_misuse_is_told_with_the_usage(arguments, cli):
    refused(cli(*arguments), r"usage: lipsync-lang.*\n(.*\n)*lipsync-lang.*: error: ")


# The program as users start it


def start(*arguments, **rest):
    rest = {"capture_output": True, "encoding": "utf-8", "check": False, "timeout": 60} | rest
    return subprocess.run(arguments, **rest)  # noqa: PLW1510 it is in rest


def script():
    name = "lipsync-lang.exe" if sys.platform == "win32" else "lipsync-lang"
    return os.path.join(os.path.dirname(sys.executable), name)  # noqa: PTH118, PTH120 a string


@pytest.mark.parametrize("program", swept([[sys.executable, "-m", "lipsync_lang"], [script()]]))
def test_the_program_starts_in_both_ways(program):
    done = start(*program, "run", *PAIR, "--schedule", "line.json", "-o", "line.csv")
    assert (done.returncode, done.stdout) == (0, "")
    assert "wrote line.csv" in done.stderr
    done = start(*program, "run", *PAIR, "--schedule", "lien.json")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "lipsync-lang: lien.json: cannot be read: No such file or directory; check the path\n"
    )


@full
@pytest.mark.skipif(sys.platform == "win32", reason="pipes end otherwise there")
@pytest.mark.parametrize("arguments", [["--help"], ["bank", "draft", *PAIR], ["schema", "bank"]])
def test_a_reader_who_has_seen_enough_is_no_error(arguments):
    command = [sys.executable, "-m", "lipsync_lang", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


@full
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")  # noqa: PTH110
def test_a_full_disk_is_told():
    with open("/dev/full", "wb") as full:  # noqa: PTH123 a device
        command = [sys.executable, "-m", "lipsync_lang", "schema", "bank"]
        done = start(*command, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr == "lipsync-lang: No space left on device\n"


@full
def test_a_terminal_that_knows_few_letters_still_gets_everything():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    command = [sys.executable, "-m", "lipsync_lang", "languages", "show", "english"]
    done = start(*command, env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    done = start(*command, "--json", env=environment)
    assert "ʃ" in [row["label"] for row in json.loads(done.stdout)["notations"]["ipa"]]


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use stays there")
def test_a_folder_that_is_gone_is_told(tmp_path):
    gone = tmp_path / "gone"
    command = f"mkdir '{gone}' && cd '{gone}' && rmdir '{gone}' && exec {sys.executable} -m "
    done = start("sh", "-c", f"{command} lipsync_lang languages")
    assert done.returncode == 2
    assert done.stderr == ("lipsync-lang: the current folder no longer exists; change to another\n")


# run


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
    (folder / "line.odd").write_text("0 1600 HH\n", "utf-8")
    assert cli("run", *PAIR, "--schedule", "line.odd", "--read-as", "timit").code == 0
    refused(cli("run", *PAIR, "--schedule", "line.odd"), "may be htk or timit; choose one")


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
        ("motion.=1", "unknown motion setting ''; known: anticipate, contacts, hold"),
        ("motion.window=", "motion.window is ''; it is a number from 0 to 10, as 0.1"),
        ("motion.window=wide", "motion.window is 'wide'; it is a number"),
        ("motion.window=-1", "motion.window is '-1'; it is a number"),
        ("motion.window=nan", "motion.window is 'nan'; it is a number"),
        ("motion.window=1e9", "motion.window is '1e9'; it is a number from 0 to 10"),
        ("motion.silence_reach=inf", "motion.silence_reach is 'inf'; it is a number"),
        ("motion.speed_limit=0", "motion.speed_limit is '0'; it is a number from 4 to 1e.06"),
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


# explain, resolve


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


def test_resolve_counts_the_layers(cli):
    ended = cli("resolve", *PAIR)
    assert (ended.code, ended.err) == (0, "")
    assert "441 bigrams: 441 shared" in ended.out
    ended = cli("resolve", *PAIR, "--json")
    assert json.loads(ended.out)["shared"] == 441


def test_a_language_answers_to_its_tag(cli):
    assert cli("resolve", "-l", "en", "-c", "facefx").out == cli("resolve", *PAIR).out


def test_gaps_are_faults(cli, folder):
    poseset = folder / "posesets" / "bare" / "poseset.yaml"
    poseset.parent.mkdir(parents=True)
    poseset.write_text("kind: poseset\nformat: 1\nname: bare\nposes: {open: {}}\n")
    ended = cli("resolve", "-l", "english", "-c", "bare")
    assert ended.code == 1
    assert "gaps: aa-aa" in ended.out or "gaps: ah-ah" in ended.out
    command = ("run", "-l", "english", "-c", "bare", "--schedule", "line.json")
    refused(cli(*command), r"bare has no curves for 441 bigrams of english.* targets .*--gaps rest")
    assert cli(*command, "--gaps", "rest").code == 0


# validate, schema, lists, formats


@full
def test_validate_prints_every_fault_with_its_place(cli, folder):
    (folder / "languages").mkdir()
    text = "kind: language\nformat: 1\nname: odd\ntag: qaa\nnotation: {}\nadds: [3]\n"
    (folder / "languages" / "odd.yaml").write_text(text)
    for where in ([], ["languages"], ["languages/odd.yaml"]):
        ended = cli("validate", *where)
        assert ended.code == 1
        assert "languages/odd.yaml:5:1: P101" in ended.out
        assert "languages/odd.yaml:6:8: P" in ended.out
        assert ended.err == "2 faults, 0 warnings\n"
    faults = json.loads(cli("validate", "--json").out)
    assert [fault["line"] for fault in faults] == [5, 6]


@full
def test_what_comes_with_the_program_is_sound(cli):
    ended = cli("validate")
    assert (ended.code, ended.out) == (0, "")
    assert ended.err == "0 faults, 0 warnings\n"
    assert json.loads(cli("validate", "--json").out) == []


def test_validate_tells_of_what_is_not_there(cli):
    ended = cli("validate", "nowhere")
    assert ended.code == 1
    assert "nowhere" in ended.out
    assert ended.err == "1 fault, 0 warnings\n"


def test_every_kind_of_pack_has_a_schema(cli):
    kinds = cli("schema").out.split()
    assert "language" in kinds
    for kind in kinds:
        assert json.loads(cli("schema", kind).out)["type"] == "object"
    refused(cli("schema", "langage"), "'langage': did you mean 'language'")


FEW = 2
"""Packs that the quick lane shows."""


@full
@pytest.mark.parametrize("kind", ["languages", "posesets", "characters"])
def test_every_pack_is_shown(kind, cli):
    for name in [row["name"] for row in json.loads(cli(kind, "list", "--json").out)][FEW:]:
        assert name in cli(kind, "show", name).out
        assert json.loads(cli(kind, "show", name, "--json").out)["name"] == name


@pytest.mark.parametrize("kind", swept(["posesets", "characters", "languages"], quick=2))
def test_packs_are_listed_and_shown(kind, cli):
    names = [row["name"] for row in json.loads(cli(kind, "list", "--json").out)]
    assert cli(kind).out == cli(kind, "list").out
    for name in names[:FEW] or ["facefx"]:
        ended = cli(kind, "show", name)
        assert (ended.code, ended.err) == (0, "")
        assert name in ended.out
        assert json.loads(cli(kind, "show", name, "--json").out)["name"] == name
    refused(cli(kind, "show"), rf"name the \w+ to show: {kind} show NAME")
    refused(cli(kind, "show", "nobody"), r"unknown .*'nobody': known: ")
    refused(cli(kind, "list", "facefx"), f"run: {kind} show facefx")


def test_packs_of_other_folders_are_found(cli, folder):
    (folder / "more" / "languages").mkdir(parents=True)
    text = "kind: language\nformat: 1\nname: odd\ntag: qaa\nextends: english\n"
    (folder / "more" / "languages" / "odd.yaml").write_text(text)
    assert "odd " in cli("languages", "--path", "more").out
    assert cli("resolve", "--path", "more", "-l", "odd", "-c", "facefx").code == 0
    refused(cli("languages", "--path", "less"), "less: no such folder; name one that holds packs")


def test_formats_lists_readers_and_writers(cli):
    rows = json.loads(cli("formats", "--json").out)
    assert {(row["direction"], row["name"]) for row in rows} > {("read", "json"), ("write", "csv")}
    assert all(row["title"] and row["suffix"].startswith(".") for row in rows)
    printed = cli("formats").out.splitlines()
    assert len(printed) == len(rows)


# bank draft


def test_drafts_are_printed_as_yaml(cli, folder):
    ended = cli("bank", "draft", *PAIR, "l-ow", "h-eh")
    assert (ended.code, ended.err) == (0, "")
    assert re.match(r"bigrams:\n  l-ow:\n    status: drafted\n    curves:\n", ended.out)
    assert listed(folder) == set()
    refused(
        cli("bank", "draft", *PAIR, "l-oe"), "unknown bigram 'l-oe' in english; did you mean 'l-o"
    )


def test_drafts_are_written_once_and_then_used(cli, folder):
    before = json.loads(cli("resolve", *PAIR, "--json").out)["layers"]
    ended = cli("bank", "draft", *PAIR, "l-ow", "bmp-bmp", "--write")
    assert (ended.code, ended.out) == (0, "")
    bank = folder / "posesets" / "facefx" / "banks" / "common.yaml"
    assert bank.is_file()
    text = bank.read_bytes()
    after = json.loads(cli("resolve", *PAIR, "--json").out)["layers"]
    assert after["shared"]["drafted"] >= before.get("shared", {}).get("drafted", 0) + 1
    ended = cli("bank", "draft", *PAIR, "l-ow", "--write")
    assert "0 drafted bigrams put into" in ended.err
    assert "1 was already there and is unchanged" in ended.err
    assert bank.read_bytes() == text


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("bank.json", "bank.json: is not a name for a bank; use a name that ends in .yaml"),
        ("line.json/bank.yaml", "line.json: cannot be made: (File exists|Not a dir)"),
        ("english.yaml", "english.yaml: is not a bank of facefx; name another file"),
        ("list.yaml", "list.yaml"),
        ("folder.yaml", "folder.yaml: "),
        ("other.yaml", "other.yaml: is not a bank of facefx"),
        ("broken.yaml", "broken.yaml:2:1: P008"),
    ],
)
def test_drafts_go_into_a_bank_or_nowhere(target, message, cli, folder, root):
    (folder / "english.yaml").write_bytes((root / "languages" / "english.yaml").read_bytes())
    (folder / "list.yaml").write_text("- 1\n")
    (folder / "other.yaml").write_text("kind: bank\nformat: 1\nname: other\nposeset: other\n")
    (folder / "broken.yaml").write_text("kind: [\n")
    (folder / "folder.yaml").mkdir()
    before = {p: p.read_bytes() for p in folder.iterdir() if p.is_file()}
    ended = cli("bank", "draft", *PAIR, "l-ow", "--to", target)
    assert ended.code in (1, 2)
    assert re.search(message, ended.err), ended.err
    assert {p: p.read_bytes() for p in folder.iterdir() if p.is_file()} == before


# Whatever anybody types

WORDS = sorted({word for words in COMMANDS for word in words})
OPTIONS = sorted({o for c in COMMANDS.values() for a in actions(c) for o in a.option_strings})
VALUES = [*PAIR, "line.json", "a.csv", ".", "", "l-ow", "motion.window=0.1", "0.2", "json", "-"]
ARGUMENTS = st.lists(
    st.sampled_from([*WORDS, *OPTIONS, *VALUES])
    | st.text(st.characters(exclude_characters="\0/"), max_size=6),
    max_size=9,
)


def ends_well(arguments, capsys):
    """Run a command, and return its exit code; every error must have a message."""
    try:
        code = main(arguments)
    except SystemExit as exit_:
        code = exit_.code
    told = capsys.readouterr()
    assert code in (0, 1, 2)
    assert "Traceback" not in told.err
    assert code == 0 or told.err or told.out
    return code


@costly()
@given(arguments=ARGUMENTS)
@example(arguments=["run", "", *PAIR])
@example(arguments=["explain", "--at", "0.2", *PAIR, "--schedule", "line.json", "--cut"])
@example(arguments=["bank", "draft", *PAIR, "--write", "--to", ""])
@example(arguments=["run", *PAIR, "--schedule", ""])
@example(arguments=["run", *PAIR, "--schedule", "line.json", "-o", ""])
@example(arguments=["validate", ""])
@example(arguments=["languages", "--path", ""])
@example(arguments=["languages", "show", "\udc80"])
@example(arguments=["validate", "\udc80"])
@example(arguments=["run", *PAIR, "--schedule", "line.json", "-o", "\udc80.csv"])
@example(arguments=["run", *PAIR, "\udc80"])
def test_no_arguments_give_a_traceback(arguments, capsys):
    ends_well(arguments, capsys)


@given(content=st.binary(max_size=120), suffix=st.sampled_from(["json", "TextGrid"]))
def test_no_file_gives_a_traceback(content, suffix, capsys, folder):
    (folder / f"odd.{suffix}").write_bytes(content)
    ends_well(["run", *PAIR, "--schedule", f"odd.{suffix}", "-o", "a.json"], capsys)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=3),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["label", "start", "end", "phonemes", "words"]), inner)
    ),
    max_leaves=8,
)
TIME = st.floats(-1, 2) | st.integers(0, 2) | JSON
ROW = st.fixed_dictionaries(
    {"label": st.sampled_from(["HH", "_", "B"]) | st.text(max_size=2), "start": TIME, "end": TIME}
)
DOCUMENT = st.fixed_dictionaries(
    {"phonemes": st.lists(ROW, max_size=3) | JSON},
    optional={
        "words": JSON | st.lists(st.fixed_dictionaries({"text": JSON, "start": JSON, "end": JSON})),
        "notation": JSON,
        "language": st.just("english") | JSON,
    },
)


@given(document=DOCUMENT | JSON, rest=st.sampled_from([[], ["--unknown", "rest"]]))
@example(document=[{"label": "\ud800", "start": 0, "end": 1}], rest=["--unknown", "rest"])
@example(document=[{"label": "HH", "start": 0, "end": 10**400}], rest=[])
@example(
    document={
        "language": "english",
        "phonemes": [{"label": "HH", "start": 0, "end": 1}],
        "words": [{"text": "\udfff", "start": 0, "end": 1}],
    },
    rest=[],
)
def test_no_document_gives_a_traceback(document, rest, capsys, folder):
    (folder / "odd.json").write_text(json.dumps(document), "utf-8")
    command = ["run", *PAIR, "--schedule", "odd.json", "-o", "a.json", "--fps", "10"]
    if ends_well([*command, *rest], capsys) == 0:
        assert json.loads((folder / "a.json").read_bytes())["frames"]
