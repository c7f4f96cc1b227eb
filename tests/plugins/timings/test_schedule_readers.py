"""Every reader of timings on damaged files: a schedule, or a refusal with a place."""

from itertools import pairwise
from random import Random

import pytest
from test_schedule import EXAMPLES

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules import Schedule, TimedWords, read_timings
from lipsync_lang.schedules.timing_readers import TIMING_READERS

every_reader = pytest.mark.parametrize("name", EXAMPLES)

ENCODINGS = ("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp037", "cp1252")

VALUES = ("NaN", "-Infinity", "1e999", "-1", "9" * 5000, '"0.1"', "null", "[]", "{}", "true")
"""Replacements for a number."""


def outcome(path, content, **options):
    """Read a file; the result must be timings or a refusal with a message."""
    path.write_bytes(content)
    try:
        return read_timings(path, **options)
    except ScheduleError as error:
        told = str(error)
    assert told.startswith(str(path))
    return told


def ways(name, tmp_path):
    """Yield paths and options with which a reader opens a file."""
    yield tmp_path / "line.unknown", {"read_as": name}
    yield from ((tmp_path / f"line{suffix}", {}) for suffix in TIMING_READERS[name].suffixes)


@every_reader
def test_a_file_that_is_cut_off_is_no_traceback(name, tmp_path):
    whole = EXAMPLES[name].encode()
    for path, options in ways(name, tmp_path):
        for size in range(0, len(whole), max(7, len(whole) // 60)):
            outcome(path, whole[:size], **options)


@every_reader
def test_a_damaged_file_is_no_traceback(name, tmp_path):
    whole, random = EXAMPLES[name].encode(), Random(name)  # noqa: S311 the same damage every time
    for path, options in ways(name, tmp_path):
        for _ in range(30):
            content = bytearray(whole)
            for _ in range(random.randint(1, 4)):
                content[random.randrange(len(content))] = random.randrange(256)
            outcome(path, bytes(content), **options)


@every_reader
def test_a_number_that_is_no_time_is_no_traceback(name, tmp_path):
    whole, random = EXAMPLES[name], Random(name)  # noqa: S311 the same damage every time
    places = [at for at, letter in enumerate(whole) if letter.isdigit()]
    for path, options in ways(name, tmp_path):
        for value in VALUES:
            at = random.choice(places)
            end = at
            while whole[end : end + 1].isdigit():
                end += 1
            outcome(path, (whole[:at] + value + whole[end:]).encode(), **options)


@every_reader
@pytest.mark.parametrize("content", [b"", b"\0" * 99, b"\xff" * 99, b"\n\n", b"7", b"[" * 10_000])
def test_what_is_nothing_is_refused(name, content, tmp_path):
    for path, options in ways(name, tmp_path):
        assert isinstance(outcome(path, content, **options), str)


@every_reader
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_an_encoding_is_read_or_refused(name, encoding, tmp_path):
    for path, options in ways(name, tmp_path):
        content = EXAMPLES[name].encode(encoding)
        found = outcome(path, content, **options)
        assert isinstance(found, Schedule | TimedWords) or encoding.startswith("cp")
        named = outcome(path, content, **options, encoding=encoding)
        assert isinstance(named, Schedule | TimedWords)


TENFOLD = "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in pairwise("abcdefghi"))
BOMB = f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "lol">{TENFOLD}]><{{root}}>&i;</{{root}}>'
LEAK = '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY e SYSTEM "file://{file}">]><{root}>&e;</{root}>'

XML = [reader.name for reader in TIMING_READERS.values() if ".xml" in reader.suffixes]
assert XML, "a sweep over nothing passes"


@pytest.mark.parametrize("name", XML)
@pytest.mark.parametrize("root", ["bml", "speak", "rhubarbResult", "lips "])
def test_entities_are_never_read(name, root, tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("secret")
    for bad in (BOMB, LEAK):
        text = bad.replace("{root}", root).replace("{file}", str(secret))
        for options in ({}, {"read_as": name}):
            told = outcome(tmp_path / "line.xml", text.encode(), **options)
            assert "secret.txt" not in told
            assert "has a <!DOCTYPE>, which is never read; remove it" in told
