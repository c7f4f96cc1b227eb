"""Text to phonemes with phonemizer: orthography profiles, Festival and eSpeak NG."""

import csv
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from unicodedata import normalize

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full

from lipsync_lang import SpeechError, speak, transcribe
from lipsync_lang.authoring.language_check import check_language
from lipsync_lang.packs.library import Library
from lipsync_lang.plugins.phonemizer import phonemizer_g2p
from lipsync_lang.text.phonology.g2p import Settings, engine
from lipsync_lang.text.phonology.g2p.g2p_engines import MissingReaderError
from lipsync_lang.text.phonology.g2p.orthography_profile import (
    MAX_GRAPHEME_CHARS,
    MAX_PROFILE_BYTES,
    Graphemes,
    ProfileRow,
    profile_rows,
    read_profile,
)

PACK = """\
kind: language
format: 1
name: valley
tag: art-x-valley
extends: ipa:art-x-valley
g2p: {engine: phonemizer, file: valley.tsv, notation: ipa}
"""
PROFILE = "Grapheme\tIPA\na\ta\nts\tt s\nt\tt\nm\tm\ni\ti\nh\tNULL\n"

installed = pytest.mark.skipif(
    not (find_spec("phonemizer") and find_spec("segments")),
    reason="the phonemizer extra is not installed",
)
festival = pytest.mark.skipif(
    shutil.which("festival") is None, reason="the program festival is not installed"
)
espeak = pytest.mark.skipif(
    find_spec("espeakng_loader") is None, reason="the speech extra is not installed"
)


def plant(folder, profile=PROFILE, pack=PACK):
    """Write a pack and its profile into a folder; return the path of the pack."""
    languages = folder / "languages"
    languages.mkdir(exist_ok=True)
    (languages / "valley.tsv").write_bytes(
        profile if isinstance(profile, bytes) else profile.encode()
    )
    (languages / "valley.yaml").write_text(pack, "utf-8")
    return languages / "valley.yaml"


def sounds_of(folder, content, column="IPA"):
    """Return the sounds of each grapheme of a profile, capitals left out."""
    file = folder / "profile.tsv"
    file.write_bytes(content)
    return {row.grapheme: row.sounds for row in profile_rows(file, column)}


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the folder for temporary files of this test, whose workers end with it."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    phonemizer_g2p.worker.cache_clear()
    yield folder
    phonemizer_g2p.worker.cache_clear()
    assert not list(folder.iterdir())


# Profiles


@pytest.mark.parametrize(
    "content",
    [
        b"Grapheme\tIPA\na\ta\nts\tt s\nh\tNULL\n",
        b"\xef\xbb\xbfGrapheme\tIPA\r\na\ta\r\nts\tt s\r\nh\tNULL\r\n",
        b"Grapheme\tIPA\ra\ta\rts\tt s\rh\tNULL",
        b"IPA\tFREQUENCY\tGrapheme\na\t9\ta\nt  s\t\tts\nNULL\t1\th\t\n\n",
        b'Grapheme\tIPA\n a \ta\n"ts"\t"t s"\n\nh\tNULL\n  \n',
    ],
)
def test_profiles_come_in_several_forms(tmp_path, content):
    assert sounds_of(tmp_path, content) == {"a": ("a",), "ts": ("t", "s"), "h": ()}


def test_a_pack_names_the_column_of_sounds(tmp_path):
    content = "Grapheme\tIPA\tXSAMPA\ngn\tɲ\tJ\n".encode()
    assert sounds_of(tmp_path, content, "XSAMPA") == {"gn": ("J",)}


def test_a_number_sign_and_a_quotation_mark_are_graphemes(tmp_path):
    assert sounds_of(tmp_path, b'Grapheme\tIPA\n#\tx\n""""\tq\n') == {"#": ("x",), '"': ("q",)}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "1: there are no graphemes"),
        (b"Grapheme\tIPA\n", "1: there are no graphemes"),
        (b"\nGraphem\tIPA\na\ta\n", "2: there is no column 'Grapheme'; did you mean 'Graphem'?"),
        (b"a\ta\n", "1: there is no column 'Grapheme'"),
        (b"Grapheme\tipa\na\ta\n", "1: there is no column 'IPA'; did you mean 'ipa'?"),
        (b"Grapheme\tIPA\na\ta\n\tb\n", "3: the grapheme is empty; write it"),
        (b"Grapheme\tIPA\na\ta\n\na\tb\n", "4: 'a' is in line 2 already; keep one of the two"),
        ("Grapheme\tIPA\né\te\ne\u0301\te\n".encode(), "3: 'e\u0301' is in line 2 already"),
        (
            b"Grapheme\tIPA\na\nb\tb\n",
            "2: 'a' has no sounds; write its sounds under `IPA`, or NULL",
        ),
        (b'Grapheme\tIPA\n"\tq\n', "2: a quotation mark is not closed"),
        (b"Grapheme\tIPA\na b\tc\n", "2: 'a b' is no grapheme; write at most 12"),
        (b"Grapheme\tIPA\n" + b"a" * 99 + b"\ta\n", "2: 'aaaaaaaaaaaaaaaaaaaaaaaa' is no grapheme"),
    ],
)
def test_mistakes_in_a_profile_are_located(tmp_path, content, message):
    file = tmp_path / "profile.tsv"
    file.write_bytes(content)
    with pytest.raises(SpeechError) as caught:
        read_profile(file)
    assert str(caught.value).startswith(f"{file}:{message}")


def test_a_file_that_is_no_profile_is_a_message(tmp_path):
    file = tmp_path / "profile.tsv"
    file.write_bytes(b"Grapheme\tIPA\n\xff\ta\n")
    with pytest.raises(SpeechError, match=r"profile.tsv: is not UTF-8 text \(byte 13\)"):
        read_profile(file)
    file.write_bytes(b"Grapheme\tIPA\n" + b"\n" * MAX_PROFILE_BYTES)
    with pytest.raises(SpeechError, match=r"is larger than 4 MB; keep one line for each grapheme"):
        read_profile(file)
    with pytest.raises(SpeechError, match=r"cannot be read"):
        read_profile(tmp_path / "none.tsv")


letters = st.characters(categories=["Ll", "Lo", "Mn", "Lm"])
spellings = st.text(letters, min_size=1, max_size=3).map(lambda text: normalize("NFD", text))
graphemes = spellings.filter(lambda text: len(text) <= MAX_GRAPHEME_CHARS)
profiles = st.dictionaries(graphemes, st.lists(graphemes, max_size=3), min_size=1, max_size=8)


@given(profiles, st.booleans(), st.sampled_from(["\n", "\r\n"]))
def test_a_profile_is_read_as_it_was_written(tmp_path_factory, drawn, turned, ending):
    table = StringIO(newline="")
    out = csv.writer(table, delimiter="\t", lineterminator=ending)
    for row in [("Grapheme", "IPA"), *((one, " ".join(to) or "NULL") for one, to in drawn.items())]:
        out.writerow(row[::-1] if turned else row)
    found = sounds_of(tmp_path_factory.mktemp("profile"), table.getvalue().encode())
    assert found == {one: tuple(to) for one, to in drawn.items()}


def greedy(known, word):
    """Cut a word as the specification does: the longest grapheme at each place."""
    at, found, left = 0, [], 0
    while at < len(word):
        fits = [one for one in known if word.startswith(one, at)]
        found += [max(fits, key=len)] if fits else []
        left += not fits
        at += len(found[-1]) if fits else 1
    return found, left


@given(
    st.lists(st.text("abc", min_size=1, max_size=3), min_size=1, unique=True),
    st.text("abcd", max_size=12),
)
def test_the_longest_grapheme_comes_first(known, word):
    rows = [ProfileRow(n, one, (one,)) for n, one in enumerate(known)]
    found, unread = Graphemes(rows).cut(word)
    assert (found, len(unread)) == greedy(known, word)


def test_capitals_marks_and_ends_of_words_are_graphemes_where_they_are_stated():
    def cut(known, word):
        return Graphemes([ProfileRow(1, normalize("NFD", one)) for one in known]).cut(word)

    assert cut(["sh", "q", "Q"], "ShqQSH") == (["Sh", "q", "Q", "SH"], "")
    assert cut(["a", "\u0301"], "á") == (["a", "\u0301"], "")
    assert cut(["a"], "á") == (["a"], "á")
    assert cut(["á"], "a\u0301A\u0301") == (["a\u0301", "A\u0301"], "")
    assert cut(["^a", "a", "b", "b$"], "abab") == (["^a", "b", "a", "b$"], "")
    assert cut(["a", "'"], "a’-a") == (["a", "'", "a"], "")


# Reading by a profile


@installed
def test_a_profile_reads_words_and_names_the_letters_that_it_lacks(tmp_path, temporary):
    file = plant(tmp_path).with_suffix(".tsv")
    settings = Settings("valley", file=file, backend="segments")
    (found,) = engine("phonemizer", settings)(["Tsami, hat: xma-ti 7 $"])
    assert [(one.text, one.labels, one.unread) for one in found] == [
        ("Tsami", ("t", "s", "a", "m", "i"), ""),
        (",", (), ""),
        ("hat", ("a", "t"), ""),
        (":", (), ""),
        ("xma-ti", ("m", "a", "t", "i"), "x"),
        ("7", (), "7"),
        ("$", (), "$"),
    ]
    assert len(list(temporary.iterdir())) == 1


@full
@installed
@pytest.mark.usefixtures("temporary")
def test_long_words_are_read_at_once(tmp_path):
    file = plant(tmp_path, "Grapheme\tIPA\na\ta\naa\taː\naaa\ta a\n").with_suffix(".tsv")
    read = engine("phonemizer", Settings("valley", file=file, backend="segments"))
    start = time.monotonic()
    (found,) = read(["a" * 3001])
    assert found[0].labels == ("a",) * 2001
    assert time.monotonic() - start < 20


@installed
@pytest.mark.usefixtures("temporary")
def test_missing_letters_are_told_with_the_file_that_lacks_them(tmp_path, cli, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = plant(tmp_path)
    advice = "valley.tsv: has no grapheme for x; add a line for each, with its sounds, or NULL"
    done = cli("transcribe", "tsamix", "-l", "valley")
    assert advice in done.err
    (heard,) = transcribe(["tsami"], "valley")
    assert (heard.labels, heard.advice) == (("t", "s", "a", "m", "i"), ())
    assert advice in speak("tsamix", "valley", engine="none").remarks[0]
    with pytest.raises(SpeechError, match=r"says nothing for 'x'.*valley\.tsv: has no grapheme"):
        speak("x", "valley", engine="none")
    tests = "tests:\n  - {text: tsamix, phonemes: [d, s, aa, bmp, iy]}\n"
    file.write_text(PACK + tests, "utf-8")
    (fault,) = check_language(Library(tmp_path), file).faults
    assert (fault.code, fault.line) == ("P221", 8)
    assert fault.what == "'tsamix' has x, which is not read"
    assert advice in fault.hint


def test_the_check_of_a_language_names_each_bad_line_of_its_profile(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own = PACK.replace("extends: ipa:art-x-valley\n", "") + "notations: {ipa: {a: aa}}\n"
    file = plant(tmp_path, "Grapheme\tIPA\na\ta\n\tb\na\ta\nm\ta ɱ\n", own)
    told = [
        (f.file, f.line, f.code, f.what) for f in check_language(Library(tmp_path), file).faults
    ]
    table = str(Path("languages/valley.tsv"))
    assert told == [
        (table, 3, "P237", "the grapheme is empty"),
        (table, 4, "P237", "'a' is in line 2 already"),
        (table, 5, "P218", "'ɱ' is not in the notation 'ipa'"),
    ]
    file = plant(tmp_path, b"\xff")
    (fault,) = check_language(Library(tmp_path), file).faults
    assert (fault.code, fault.line) == ("P237", 6)
    assert "is not UTF-8 text" in fault.what
    file = plant(tmp_path, pack=PACK.replace("file: valley.tsv, ", ""))
    (fault,) = check_language(Library(tmp_path), file).faults
    assert (fault.code, fault.what) == ("P237", "the pack names no orthography profile")
    file = plant(tmp_path, pack=PACK.replace("valley.tsv", "../../other.tsv"))
    (tmp_path.parent / "other.tsv").write_text(PROFILE, "utf-8")
    (fault,) = check_language(Library(tmp_path), file).faults
    assert (fault.code, fault.what) == ("P213", "languages/ has no file '../../other.tsv'")


def test_a_profile_that_is_not_named_and_an_extra_that_is_missing_are_messages(monkeypatch):
    if find_spec("phonemizer"):
        with pytest.raises(SpeechError, match="reads by an orthography profile, but names none"):
            engine("phonemizer", Settings("valley", backend="segments"))
    monkeypatch.setattr(phonemizer_g2p, "find_spec", lambda _: None)
    with pytest.raises(MissingReaderError, match=r"not installed.*lipsync-lang\[phonemizer\]"):
        engine("phonemizer", Settings("valley", backend="segments"))


# Voices


def labels_of(settings, text):
    """Return the words of a text with their labels, by a voice of phonemizer."""
    (found,) = engine("phonemizer", settings)([text])
    return [(word.text, *word.labels) for word in found]


@full
@installed
@festival
@pytest.mark.usefixtures("temporary")
def test_festival_reads_clause_by_clause_and_syllables_stay_apart():
    settings = Settings("test", code="en-us", backend="festival")
    assert labels_of(settings, "Hello, wörld. ж \\ 'tis (10) !") == [
        ("Hello", "hh", "ax", "l", "ow"),
        (",",),
        ("wörld", "w", "er", "l", "d"),
        (",",),
        ("ж \\ 'tis", "t", "iy", "z"),
        ("10", "t", "eh", "n"),
    ]


@full
@installed
@espeak
@pytest.mark.parametrize("voice", ["en-us", "de", "es", "fr-fr"])
@pytest.mark.usefixtures("temporary")
def test_espeak_reads_as_the_worker_does(voice):
    text = "Rosa, Tom und 10 Mango. Animal? Radio"
    (found,) = engine("phonemizer", Settings("test", voice=voice, backend="espeak"))([text])
    (known,) = engine("espeak", Settings("test", voice=voice))([text])
    assert [one for one in found if one.labels] == [one for one in known if one.labels]


@full
@installed
@espeak
@pytest.mark.usefixtures("temporary")
def test_a_language_that_a_backend_lacks_is_a_message():
    with pytest.raises(SpeechError, match=r"espeak has no language 'en-uss'; did you mean 'en-us'"):
        labels_of(Settings("test", code="en-uss", backend="espeak"), "a")


@installed
def test_a_missing_festival_is_a_message(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(SpeechError, match="the program festival, which is not installed"):
        engine("phonemizer", Settings("test", code="en-us", backend="festival"))


# Temporary files


@full
@installed
@espeak
def test_temporary_files_go_when_a_worker_is_killed(temporary):
    read = engine("phonemizer", Settings("test", voice="de", backend="espeak"))
    list(read(["Rosa"]))
    (folder,) = temporary.iterdir()
    assert list(folder.iterdir())  # copies of the library
    process = phonemizer_g2p.worker(os.getpid(), "espeak", "de", ()).process
    process.kill()
    process.wait()
    with pytest.raises(SpeechError, match="phonemizer ended without an answer for 1 texts"):
        list(read(["Tom"]))
    assert not folder.exists()
    assert list(read(["Tom"]))


CHILD = """
import os, sys, tempfile
from lipsync_lang.text.phonology.g2p import Settings, engine
list(engine("phonemizer", Settings("test", voice="de", backend="espeak"))(["Rosa"]))
print(*os.listdir(tempfile.gettempdir()), flush=True)
sys.stdin.read()
"""


@full
@installed
@espeak
@pytest.mark.skipif(sys.platform == "win32", reason="it sends signals")
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_temporary_files_go_when_the_program_is_killed(end, temporary):
    command = [sys.executable, "-c", CHILD]
    settings = {**os.environ, "TMPDIR": str(temporary)}
    pipe = subprocess.PIPE
    with subprocess.Popen(
        command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, env=settings
    ) as program:
        assert b"lipsync-tmp" in program.stdout.readline()
        program.send_signal(end)
        program.wait(20)
        deadline = time.monotonic() + 20
        while list(temporary.iterdir()) and time.monotonic() < deadline:
            time.sleep(0.05)
    assert not list(temporary.iterdir())


@installed
def test_a_draft_of_a_profile_takes_it_along(tmp_path, cli, monkeypatch):
    monkeypatch.chdir(tmp_path)
    profile = tmp_path / "graphemes.tsv"
    profile.write_text("Grapheme\tIPA\na\ta\nsh\tʃ\nts\tt s\nh\tNULL\n", "utf-8")
    ended = cli("languages", "new", "valley", "--profile", profile, "--tag", "art-x-valley")
    assert ended.code == 0, ended.err
    assert (tmp_path / "languages" / "valley.tsv").read_bytes() == profile.read_bytes()
    assert {*Library().language("valley").model.notations["ipa"]} == {"ʃ", "t", "s", "a"}
    assert "ʃ a t s a" in cli("transcribe", "shahtsa", "-l", "valley").out
    assert cli("validate", "languages/valley.yaml").code == 0
