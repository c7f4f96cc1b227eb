"""Readings on disk: a second count of the same lines reads no text."""

import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest
from shipped import LIBRARY

import lipsync_lang as ll
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.reports.coverage.reading_cache import READINGS_FILE, reading_cache
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines import Line
from lipsync_lang.text.phonology.g2p import SpokenWord
from lipsync_lang.text.phonology.manner import Manner

RULED = next(
    name
    for name in sorted(one.name for one in LIBRARY.names("language"))
    if (g2p := LIBRARY.language(name).model.g2p) and g2p.engine == "rules"
)
"""A language that is read by rules, without an engine to start."""

WORDS = {
    "ta sa": (SpokenWord("ta", ("t", "a"), "", "x", (None, 1)), SpokenWord("sa", (), "za", "", ())),
    "\ud800": (),
}


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    return tmp_path / "cache"


@pytest.fixture
def performer():
    return ll.resolve(RULED, "crab")


def counted():
    texts = [test.text for test in LIBRARY.language(RULED).model.tests[:5]]
    lines = [Line(text, f"a.txt:{number}", "a.txt") for number, text in enumerate(texts, 1)]
    return coverage(lines, RULED, "crab").to_dict()


def test_words_are_kept_as_they_were_read(performer):
    reading_cache(performer).update(WORDS)
    kept = reading_cache(performer)
    assert {text: kept.get(text) for text in WORDS} == WORDS
    assert kept.get("sa") is None


def test_a_second_count_reads_nothing_and_says_the_same(monkeypatch):
    first = counted()
    monkeypatch.setattr(Speaker, "_read_plainly", lambda *_: pytest.fail("it reads again"))
    assert counted() == first


def test_other_settings_are_other_readings(performer, monkeypatch):
    reading_cache(performer).update(WORDS)
    plain = performer.compiled.manner
    assert Manner.from_plain(plain).words != {"ta": ("d", "aa")}
    changed = replace(performer.compiled, manner={**plain, "words": {"ta": ("d", "aa")}})
    assert reading_cache(replace(performer, compiled=changed)).get("ta sa") is None
    monkeypatch.setattr("lipsync_lang.reports.coverage.reading_cache.versions", lambda: ["newer"])
    assert reading_cache(performer).get("ta sa") is None


@pytest.mark.parametrize("harm", ["bytes", "folder", "words", "locked", "large"])
def test_a_file_that_is_no_use_costs_only_time(home, harm, monkeypatch):
    first = counted()
    path = home / READINGS_FILE
    if harm == "bytes":
        path.write_bytes(b"no data base" * 1000)
    elif harm == "folder":
        path.unlink()
        path.mkdir()
    elif harm == "words":
        with sqlite3.connect(path) as rows:
            rows.execute("UPDATE readings SET words = '[[1]]'")
    elif harm == "locked":
        holder = sqlite3.connect(path, isolation_level=None)
        holder.execute("BEGIN EXCLUSIVE")
    else:
        monkeypatch.setattr("lipsync_lang.reports.coverage.reading_cache.MAX_READINGS_BYTES", 1)
    assert counted() == first


def test_no_folder_and_foreign_engines_keep_nothing(performer, monkeypatch):
    monkeypatch.setattr("lipsync_lang.reports.coverage.reading_cache.G2P_ENGINES.modules", {})
    assert reading_cache(performer) is None
    monkeypatch.undo()
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", "off")
    assert reading_cache(performer) is None
    assert not Path(READINGS_FILE).exists()
