"""Lines: every format, markup, encodings, folders, and unreadable files."""

import json
import re
from collections import deque
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, needs_plug_ins
from script_samples import FILES

from lipsync_lang import LipsyncError
from lipsync_lang.schedules.timing_readers import TIMING_READERS
from lipsync_lang.text.lines import Line, read_lines
from lipsync_lang.text.lines.line_readers import LINE_READERS, LineFile, TableLayout, by_suffix
from lipsync_lang.text.lines.markup import spoken
from lipsync_lang.text.lines.table import MAX_FAULTS


def write(path: Path, text: str | bytes, encoding: str = "utf-8") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return path


def read(*paths, **options) -> list[Line]:
    return list(read_lines(paths, **options))


def refusal(path: Path) -> str:
    """Return the fault of a file; `nothing` if it can be read."""
    try:
        read(path, remark=lambda _: None)
    except LipsyncError as error:
        return str(error)
    return "nothing"


def told(lines: list[Line]) -> list[tuple[int, str, str, str]]:
    return [(int(x.place.rpartition(":")[2]), x.name, x.speaker, x.text) for x in lines]


# Markup


@pytest.mark.parametrize(
    ("written", "said", "dropped"),
    [
        ("Plain  text.", "Plain text.", ()),
        ("a <i>won</i>derful day", "a wonderful day", ("<i>", "</i>")),
        ("{i}Well{/i}{w=0.5}, yes", "Well, yes", ("{i}", "{/i}", "{w=0.5}")),
        ("{\\an8}Top", "Top", ("{\\an8}",)),
        ("Hi [player!t], [names['a']]!", "Hi, !", ("[player!t]", "[names['a']]")),
        ("Hi {name}, {0:>3}", "Hi,", ("{name}", "{0:>3}")),
        ("%s has %(count)d of %1$s", "has of", ("%s", "%(count)d", "%1$s")),
        ("100% sure, 5% discount", "100% sure, 5% discount", ()),
        ("%d%% done", "% done", ("%d",)),
        ("$name pays $5 to ${who}", "pays $5 to", ("$name", "${who}")),
        ("one\\ntwo\nthree", "one two three", ()),
        ("{{two words}} and [[brackets]]", "two words and brackets", ()),
        ("<ruby>漢<rt>かん</rt></ruby>字", "漢字", ("<ruby>", "<rt>かん</rt>", "</ruby>")),
        ("{rb}東{/rb}{rt}とう{/rt}", "東", ("{rb}", "{/rb}", "{rt}とう{/rt}")),
        ("♪ la la ♪", "la la", ("♪", "♪")),
        ("I <3 you, 1 < 2 > 0", "I you, 1 < 2 > 0", ("<3",)),
        ('\\"Yes\\", she said', '"Yes", she said', ()),
        ("{name}", "", ("{name}",)),
        ("", "", ()),
    ],
)
def test_what_is_written_and_what_is_said(written, said, dropped):
    assert spoken(written)[:2] == (said, dropped)


@given(st.text())
def test_no_markup_is_too_odd(text):
    said, dropped, gaps, _ = spoken(text)
    assert said == " ".join(said.split())
    assert all(dropped)
    assert list(gaps) == sorted(gaps)
    assert all(0 <= gap <= len(said) for gap in gaps)


@given(st.text(alphabet="abc äñ漢,.!?'-", max_size=40))
def test_text_without_markup_stays(text):
    text = text.lstrip(" -")  # a dash before a word is a bullet
    assert spoken(text)[:3] == (" ".join(text.split()), (), ())


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("Hello, {name}. And you?", "Hello,|. And you?"),
        ("[sighs] I told you", "|I told you"),
        ("a %s b $who", "a| b|"),
        ("a <i>won</i>derful {i}day{/i}{w=0.5}, ♪ {\\an8}yes", "a wonderful day, yes"),
        ("{{one, x}} {two} \\n three", "one, x| three"),
        ("漢{rt}かん{/rt}字{x}{y}", "漢字||"),
    ],
)
def test_a_gap_is_where_something_else_is_heard(written, said):
    text, _, gaps, _ = spoken(written)
    for gap in reversed(gaps):
        text = f"{text[:gap]}|{text[gap:]}"
    assert text == said


def test_a_column_that_no_file_has_is_told(tmp_path):
    (tmp_path / "a.txt").write_text("One.", encoding="utf-8")
    told = []
    assert len(list(read_lines([tmp_path], column="en", remark=told.append))) == 1
    assert told == ["`column='en'`: not used, because no file is a table"]
    (tmp_path / "b.csv").write_text("id,en\n1,Two.", encoding="utf-8")
    assert len(list(read_lines([tmp_path], column="en", remark=told.append))) == 2
    assert len(told) == 1


# Formats

SAMPLES = {
    ".txt": ("One.\n\n  \nTwo.\n", [(1, "", "", "One."), (4, "", "", "Two.")]),
    ".csv": (
        'id,speaker,text\n1,Ann,"Hello,\nyou"\n2,Bob,\n3,Bob,Bye\n',
        [(2, "1", "Ann", "Hello, you"), (5, "3", "Bob", "Bye")],
    ),
    ".tsv": ("key\tline\na\tHello\n", [(2, "a", "", "Hello")]),
    ".srt": (
        (
            "1\n00:00:01,000 --> 00:00:02,000\n- <i>Hi</i>.\n- You &amp; me\n\n\n"
            "2\n00:00:03,000 --> 00:00:04,000\nBye\n\nfor now\n"
        ),
        [(3, "1", "", "Hi. You & me"), (9, "2", "", "Bye"), (11, "", "", "for now")],
    ),
    ".vtt": (
        (
            "WEBVTT - title\n\nNOTE not\nspoken\n\nfirst\n00:01.000 --> 00:02.000 align:start\n"
            "<v Ann>Hello <c.loud>you</c></v>\n\nSTYLE\n::cue {}\n"
        ),
        [(8, "first", "Ann", "Hello you")],
    ),
    ".po": (
        (
            'msgid ""\nmsgstr ""\n"Content-Type: text/plain; charset=UTF-8\\n"\n\n'
            'msgctxt "greet"\nmsgid "Hello"\nmsgstr ""\n"Bon"\n"jour"\n'
            '#, fuzzy\nmsgid "a"\nmsgstr "b"\n\n'
            'msgid "%d file"\nmsgid_plural "%d files"\n'
            'msgstr[0] "fichier"\nmsgstr[1] "fichiers"\n\n'
            '#~ msgid "c"\n#~ msgstr "d"\n'
        ),
        [(7, "greet", "", "Bonjour"), (16, "", "", "fichier"), (17, "", "", "fichiers")],
    ),
    ".pot": (
        (
            'msgid ""\nmsgstr ""\n\n#: place\nmsgid "One \\"more\\"\\nrow"\nmsgstr ""\n\n'
            'msgid "A"\nmsgid_plural "B"\nmsgstr[0] ""\nmsgstr[1] ""\n'
        ),
        [(5, "", "", 'One "more" row'), (8, "", "", "A"), (9, "", "", "B")],
    ),
    ".rpy": (
        """\
# comment "not this"
define e = Character("Eileen", color="#fff")
image e happy = "e.png"
label start:
    play music "song.ogg"
    e "Hello, {i}you{/i}! It's [player]. \\"Yes\\"\\nno" # "no"
    e happy @ -wave "Attributes" (what_size=3) with dissolve
    "Bob" "Named."
    'Narrated, don\\'t you see?'
    e "Over
       two lines."
    extend " more"
    custom don't care
    $ x = "python"
    python:
        y = "not"

        z = {"a": "b"}
    e \"\"\"
    First paragraph
    goes on.

    Second.
    \"\"\"
    menu:
        "What now?"
        "Tea" if tea > 1:
            e "Tea it is."
screen hello():
    text "not"
translate french start_915:
    # e "Hello"
    e "Bonjour"
translate french strings:
    old "Tea"
    new "Thé"
    old "Cup"
    new ""
""",
        [
            (6, "start_27d3bb76", "e", 'Hello, you! It\'s. "Yes" no'),
            (7, "start_c986a26e", "e", "Attributes"),
            (8, "start_93d83f0b", "Bob", "Named."),
            (9, "start_77437ece", "", "Narrated, don't you see?"),
            (10, "start_9e400b12", "e", "Over two lines."),
            (12, "start_149e884a", "", "more"),
            (20, "start_779bae6f", "e", "First paragraph goes on."),
            (23, "start_64edecf2", "e", "Second."),
            (26, "", "", "What now?"),
            (27, "", "", "Tea"),
            (28, "start_7b8b600d", "e", "Tea it is."),
            (33, "start_915", "e", "Bonjour"),
            (36, "", "", "Thé"),
        ],
    ),
    ".yarn": (
        """\
# a tag of the file
title: Start
tags: intro
---
// nobody says this
Anna: Hello there. #line:0a1b // nor this
<<declare $n = 1>>
Old Man: Hi {$name}, see http://a.b/c. #mood:sad #line:0a1c
    [wave]Well[/wave], it costs 5 # or 6.
-> Yes, please. <<if $n > 0>> #line:0a1d
    Anna: Fine: go.
=> Anna: Aye\\: aye.
[[Leave|Next]]
[[Next]]
He said: "No."
===
title: Next
---
Bye. #line:0a1e
===
""",
        [
            (6, "0a1b", "Anna", "Hello there."),
            (8, "0a1c", "Old Man", "Hi, see."),
            (9, "", "", "Well, it costs 5 # or 6."),
            (10, "0a1d", "", "Yes, please."),
            (11, "", "Anna", "Fine: go."),
            (12, "", "Anna", "Aye: aye."),
            (13, "", "", "Leave"),
            (15, "", "He said", '"No."'),
            (19, "0a1e", "", "Bye."),
        ],
    ),
    ".ink": (
        """\
VAR met = false
=== start ===
Anna: Hello there. #happy
// a comment
* (yes) {met} [Go on.] You go on. -> END
+ Stay -> start
- {met: We met|We did not meet} before. <>
~ met = true
-> END
""",
        [
            (3, "", "Anna", "Hello there."),
            (5, "yes", "", "Go on."),
            (5, "yes-1", "", "You go on."),
            (6, "", "", "Stay"),
            (7, "", "", "We met before."),
        ],
    ),
    ".properties": (
        "# Greetings\ngreeting = Hello, {0}!\nlong: One \\\n   two\nüm=\\u00fcber\nend = Bye. \\\n",
        [
            (2, "greeting", "", "Hello, !"),
            (3, "long", "", "One two"),
            (5, "üm", "", "über"),
            (6, "end", "", "Bye."),
        ],
    ),
    **FILES,
}
"""Example files by suffix, with their lines: place, name, speaker, text."""

SAMPLES = {suffix: one for suffix, one in SAMPLES.items() if suffix in by_suffix()}

REMARKED = {".archive", ".po", ".rpy", ".xlf"}
"""Example files with a part that is left out with a remark."""


def test_every_format_has_a_sample():
    texts = {s for r in LINE_READERS.values() if r.name != "schedule" for s in r.suffixes}
    assert set(SAMPLES) == texts - {".xlsx"}, "spreadsheets are no text, and have their own tests"


@pytest.mark.parametrize("suffix", SAMPLES)
def test_what_is_said_in_each_format(tmp_path, suffix):
    text, wanted = SAMPLES[suffix]
    remarks = []
    path = write(tmp_path / f"a{suffix}", text)
    lines = read(path, remark=remarks.append)
    assert told(lines) == wanted
    assert all(line.file == str(path) for line in lines)
    assert bool(remarks) == (suffix in REMARKED)


@pytest.mark.parametrize("ends", ["\r\n", "\r"])
@pytest.mark.parametrize("suffix", SAMPLES)
def test_other_ends_of_lines_are_the_same_lines(tmp_path, suffix, ends):
    text, wanted = SAMPLES[suffix]
    path = write(tmp_path / f"a{suffix}", text.replace("\n", ends))
    assert told(read(path, remark=lambda _: None)) == wanted


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-32"])
@pytest.mark.parametrize("suffix", SAMPLES)
def test_marked_encodings_are_known(tmp_path, suffix, encoding):
    text, wanted = SAMPLES[suffix]
    path = write(tmp_path / f"a{suffix}", text, encoding)
    assert told(read(path, remark=lambda _: None)) == wanted


@pytest.mark.parametrize("suffix", SAMPLES)
def test_an_empty_file_has_no_lines_or_says_why(tmp_path, suffix):
    path = write(tmp_path / f"a{suffix}", "")
    assert refusal(path).startswith((f"{path}:1: has no", "nothing"))


@given(st.text(st.characters(codec="utf-8"), max_size=200), st.sampled_from(sorted(SAMPLES)))
def test_no_text_gives_a_traceback(tmp_path_factory, text, suffix):
    path = write(tmp_path_factory.mktemp("odd") / f"a{suffix}", text, "utf-8-sig")
    assert refusal(path).startswith((str(path), "nothing"))


@given(st.binary(max_size=200), st.sampled_from(sorted(SAMPLES)))
def test_no_bytes_give_a_traceback(tmp_path_factory, content, suffix):
    path = write(tmp_path_factory.mktemp("odd") / f"a{suffix}", content)
    assert refusal(path).startswith((str(path), "nothing"))


def test_timed_phonemes_come_as_they_are(tmp_path):
    phonemes = [{"label": "HH", "start": 0, "end": 0.1}, {"label": "AY", "start": 0.1, "end": 0.3}]
    words = [{"text": "hi", "start": 0, "end": 0.3}]
    path = tmp_path / "hi.json"
    write(path, json.dumps({"phonemes": phonemes, "words": words}))
    (line,) = read(path)
    assert (line.text, line.name, line.place) == ("hi", "hi", f"{path}:1")
    assert line.schedule.labels == ("HH", "AY")


TIMED = {
    ".csv": "phone,start,end,word\nHH,0,0.1,hi\nAY,0.1,0.3,hi\n",
    ".tsv": "start\tend\tlabel\n0\t0.1\tHH\n0.1\t0.3\tAY\n",
    ".txt": "0.000000\t0.100000\tHH\n0.100000\t0.300000\tAY\n",
}


@pytest.mark.parametrize("suffix", [".csv", ".tsv", pytest.param(".txt", marks=needs_plug_ins)])
def test_a_table_or_text_that_begins_like_timed_phonemes_is_no_text(tmp_path, suffix):
    path = write(tmp_path / f"hi{suffix}", TIMED[suffix])
    (line,) = read(path)
    assert line.schedule.labels == ("HH", "AY")
    write(tmp_path / f"hi{suffix}", SAMPLES[suffix][0])
    assert all(line.schedule is None for line in read(path, remark=lambda _: None))


def test_a_column_that_is_asked_for_makes_a_table_of_timed_phonemes_too(tmp_path):
    path = write(tmp_path / "hi.csv", TIMED[".csv"])
    assert [line.text for line in read(path, column="word")] == ["hi", "hi"]


def test_what_is_doubtful_about_timed_phonemes_is_told(tmp_path):
    path = write(tmp_path / "hi.csv", "phone,start,end\nHH,0,80\nAY,80,200\n")
    remarks = []
    (line,) = read(path, remark=remarks.append)
    assert line.schedule.end == 0.2
    assert "read as milliseconds" in remarks[0]


def test_an_encoding_is_that_of_timed_phonemes_too(tmp_path):
    path = write(tmp_path / "hi.csv", "phone,start,end\n\xe4,0,0.1\n", "latin-1")
    (line,) = read(path, encoding="latin-1")
    assert line.schedule.labels == ("\xe4",)


def test_every_format_of_timed_phonemes_is_read():
    assert {s for r in TIMING_READERS.values() for s in r.suffixes} <= set(by_suffix())


# Tables


def test_a_column_by_name_or_number(tmp_path):
    path = write(tmp_path / "a.csv", "id;en;de\n1;Hello;Hallo\n")
    for column in ("de", "DE", "3"):
        assert [line.text for line in read(path, column=column)] == ["Hallo"]


@pytest.mark.parametrize(
    ("column", "match"),
    [
        ("fr", "a.tsv:1: has no column 'fr'.*Its columns: id, en, de"),
        ("9", "no column '9'"),
        (None, "which column is the text. Say `column=.NAME.`. Its columns: id, en, de"),
    ],
)
def test_a_column_that_is_not_there_names_the_columns(tmp_path, column, match):
    path = write(tmp_path / "a.tsv", "id\ten\tde\n1\tHello\tHallo\n")
    with pytest.raises(LipsyncError, match=match):
        read(path, column=column)


def test_many_names_are_summed_up(tmp_path):
    names = [f"c{number}" for number in range(400)]
    summed = f"{', '.join(names[:24])} and 376 more"
    assert refusal(write(tmp_path / "a.csv", ",".join(names))).endswith(f"Its columns: {summed}")
    workbook(tmp_path / "a.xlsx", One=[HEAD], **{name: [["x"]] for name in names})
    hidden = sorted(f".{name}" for name in names)
    (tmp_path / "b").mkdir()
    for name in hidden:
        (tmp_path / "b" / name).touch()
    remarks = []
    read(tmp_path / "a.xlsx", tmp_path / "b", remark=remarks.append)
    assert f"left out {summed}: the columns differ" in remarks[1]
    assert remarks[0].endswith(f"{', '.join(hidden[:24])} and 376 more")


def test_the_only_column_left_is_the_text(tmp_path):
    path = write(tmp_path / "a.csv", "line_id|speaker|french\n1|e|Oui, bon\n")
    assert told(read(path)) == [(2, "1", "e", "Oui, bon")]


TABLE_FAULTS = {
    "too many cells": (
        "id,speaker,text\na,x,Hello, there.\nb,x,Fine.\n",
        ['a.csv:2: has 4 cells, and the head 3 columns; put .*, such as "Hello, there."'],
        ["Fine."],
    ),
    "a text in the middle": (
        "id,text,speaker\na,Oh, no.,x\nb,Fine.,x\n",
        ['a.csv:2: .* such as "Oh, no."'],
        ["Fine."],
    ),
    "an open quote": (
        'id,text\na,"Hello.\nb,"Fine."\nc,"Bye."\n',
        ["a.csv:2: .* is not closed"],
        ["Fine.", "Bye."],
    ),
    "an open quote to the end": (
        'id,speaker,text\na,x,"Hello.\nb,x,Fine.\nc,x,Bye.\n',
        ["a.csv:2: .* is not closed"],
        ["Fine.", "Bye."],
    ),
    "an open quote in the last row": ('id,text\na,Fine.\nb,"Bye', ["a.csv:3: "], ["Fine."]),
    "a row in a cell": (
        'id,speaker,text\na,x,"Hello.\nb,x,Fine."\nc,x,Bye.\n',
        ["a.csv:2: a cell goes on in line 3, which looks like a row; close its quote"],
        ["Bye."],
    ),
    "a cell without end": (
        "text\nfine\n" + '"open\n' + "more\n" * 300,
        ["a.csv:3: .* is not closed"],
        ["fine", *["more"] * 300],
    ),
    "several": (
        'id\ttext\n1\ta\tb\n2\t"c\n3\td\n4\te\tf\n5\tg\n',
        ["a.csv:2: .*'tab'", "a.csv:3: .* is not closed", "a.csv:5: has 3 cells"],
        ["d", "g"],
    ),
    "the head": ('id,"text\na,Hello\n', ["a.csv:1: .* is not closed"], []),
    "a cell of any size": ("text\nfine\n" + "x" * 200_000, ["a.csv:3: .*131,072"], ["fine"]),
    "a column of any size": (f"id,text,{'x' * 200_000}\na,Fine", ["a.csv:1: .*131,072"], []),
    "a quoted one": (f'id,text,"{"x" * 200_000}"\na,Fine', ["a.csv:1: .*131,072"], []),
}


@pytest.mark.parametrize("case", TABLE_FAULTS)
def test_a_table_loses_no_text_silently(tmp_path, case):
    content, faults, sound = TABLE_FAULTS[case]
    path, found = write(tmp_path / "a.csv", content), []
    with pytest.raises(LipsyncError) as raised:
        found.extend(line.text for line in read_lines(path))
    assert found == sound
    for fault, line in zip(faults, str(raised.value).splitlines(), strict=True):
        assert re.search(fault, line), line


SOUND_TABLES = {
    "prose in lines": (
        'id,text\na,"Well,\nyes, I know, thanks.\n1, 2"\nb,x',
        "Well, yes, I know, thanks. 1, 2",
    ),
    "quotes in quotes": ('id,text\na,"Say "no" to me"\nb,x', 'Say no" to me"'),
    "quotes inside": ("id,text\na,He is 6' 2\" tall\nb,x", "He is 6' 2\" tall"),
    "a row that begins with a space": ('id,text\na,"Two:\n b,Fine."\nb,x', "Two: b,Fine."),
    "a head of two lines": ('id,"text\n(en)"\na,Hello\nb,x', "Hello"),
    "many columns": (f"id,text{',c' * 99_999}\na,Hello\nb,x", "Hello"),
    "empty cells at the end": ("id,text\na,Hello,, ,\nb,x", "Hello"),
}


@pytest.mark.parametrize("case", SOUND_TABLES)
def test_cells_with_lines_and_quotes_are_read(tmp_path, case):
    content, text = SOUND_TABLES[case]
    assert [line.text for line in read(write(tmp_path / "a.csv", content))] == [text, "x"]


def test_a_long_table_is_read_as_a_stream_up_to_its_faults(tmp_path, monkeypatch):
    path = write(
        tmp_path / "a.csv", "id,text\n" + "a,Hello\n" * 20_000 + 'b,"open\n' + "c,x,y\n" * 500
    )
    taken, numbered = [], LineFile.numbered
    monkeypatch.setattr(LineFile, "numbered", lambda self: map(counted, numbered(self)))

    def counted(line):
        taken.append(line)
        return line

    lines = read_lines(path)
    next(lines)
    assert len(taken) == 2
    with pytest.raises(LipsyncError, match=r"a.csv:20002: .* is not closed") as raised:
        deque(lines, maxlen=0)
    assert str(raised.value).count("\n") == MAX_FAULTS - 1
    assert len(taken) < 20_200


def test_short_rows_hold_nothing(tmp_path):
    path = write(tmp_path / "a.csv", "id,text\n1\n\n2,Hello\n")
    assert [line.text for line in read(path)] == ["Hello"]


# Files and folders


def test_folders_are_read_in_order_of_name(tmp_path):
    for name in ("b.txt", "a.txt", "c/d.txt", "C/e.TXT"):
        write(tmp_path / name, name)
    assert [line.text for line in read(tmp_path)] == ["a.txt", "b.txt", "C/e.TXT", "c/d.txt"]


def test_a_file_twice_is_read_once(tmp_path):
    path = write(tmp_path / "a.txt", "One")
    assert len(read(path, tmp_path, path)) == 1
    assert len(list(read_lines(str(path)))) == 1


def test_what_nothing_reads_is_named(tmp_path):
    write(tmp_path / "a.txt", "One")
    for name in ("b.png", "c.png", "README", ".git/config"):
        write(tmp_path / name, "x")
    remarks = []
    assert len(read(tmp_path, remark=remarks.append)) == 1
    shown = "\n".join(remarks)
    assert "b.png and 1 more: left out: no reader for '.png'" in shown
    assert "README" in shown
    assert ".git" in shown


def test_a_file_of_a_folder_that_is_no_schedule_is_left_out_with_a_remark(tmp_path):
    path = write(tmp_path / "package.json", "{}")
    remarks = []
    assert read(tmp_path, remark=remarks.append) == []
    assert str(path) in remarks[0]
    with pytest.raises(LipsyncError, match=r"none of the formats that end in '.json'"):
        read(path)


@pytest.mark.parametrize(
    ("name", "match"),
    [("gone.txt", "no such file"), ("a.docx", "no reader of lines for '.docx'; known: .*.txt"),
     ("README", "has no suffix; known")],
)  # fmt: skip
def test_a_path_that_cannot_be_read_is_named_at_once(tmp_path, name, match):
    if name != "gone.txt":
        write(tmp_path / name, "x")
    with pytest.raises(LipsyncError, match=match):
        read_lines([tmp_path / name])


@pytest.mark.parametrize(
    ("content", "match"),
    [
        ("One\nGrüße\n".encode("latin-1"), r"a.txt:2: is not UTF-8 .* UTF-16 .*`encoding="),
        (b"One\n\0\x01\x02", r"a.txt:2: has zero bytes"),
        ("One".encode("utf-16-le"), r"a.txt:1: has zero bytes.*`encoding='utf-16-le'`"),
        (b"\xff\xfea\0b", r"a.txt: starts with the mark of UTF-16 but is not .*; save it as UTF-8"),
        (b"x" * 1_000_001, r"a.txt:1: this line is longer"),
    ],
)
def test_what_is_no_text_says_what_was_tried(tmp_path, content, match):
    path = write(tmp_path / "a.txt", content)
    with pytest.raises(LipsyncError, match=match):
        read(path)


def test_an_encoding_can_be_named(tmp_path):
    path = write(tmp_path / "a.txt", "Grüße", "latin-1")
    assert [line.text for line in read(path, encoding="cp1252")] == ["Grüße"]
    with pytest.raises(LipsyncError, match="unknown encoding"):
        read(path, encoding="klingon")
    with pytest.raises(LipsyncError, match="is not ascii"):
        read(path, encoding="ascii")


@full
def test_lines_are_streamed(tmp_path):
    path = write(tmp_path / "a.txt", "One\n" * 100_000 + "\0")
    lines = read_lines([path])
    assert next(lines).text == "One"
    with pytest.raises(LipsyncError, match=r"a.txt:100001: "):
        list(lines)


def test_real_dialogue_is_read_in_every_language(data):
    path = data / "text" / "the_question_lines.tsv"
    head = path.read_text("utf-8").split("\n", 1)[0].split("\t")
    for column in head[2:]:
        lines = read(path, column=column)
        assert len(lines) > 60
        assert all(line.name and line.text for line in lines)


def test_real_sentences_are_read_whole(data):
    path = data / "text" / "harvard-sentences.txt"
    lines = read(path)
    assert [line.text for line in lines] == path.read_text("utf-8").splitlines()
    assert lines[-1].place == f"{path}:720"


# Spreadsheets


def workbook(path, **sheets):
    openpyxl = pytest.importorskip("openpyxl", reason="the extra `tables` is not installed")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


HEAD = ["id", "speaker", "text", None]


def test_spreadsheets_are_tables(tmp_path):
    path = workbook(
        tmp_path / "a.xlsx",
        One=[HEAD, ["a", "Anna", "Hello."], [None, None, None], [7.0, None, 42]],
        Two=[HEAD, ["b", "Bob", "<i>Bye</i>."]],
        Notes=[["what", "when"], ["x", "y"]],
    )
    remarks = []
    lines = read(path, remark=remarks.append)
    assert [(x.place, x.name, x.speaker, x.text) for x in lines] == [
        (f"{path}:2", "a", "Anna", "Hello."),
        (f"{path}:4", "7", "", "42"),
        (f"{path}:Two!2", "b", "Bob", "Bye."),
    ]
    assert lines[2].file == str(path)
    assert remarks == [f"{path}: left out Notes: the columns differ from those of One"]
    assert [x.text for x in read(path, column="speaker", remark=_quiet)] == ["Anna", "Bob"]
    assert "has no column 'txt'; did you mean 'text'?" in _refusal_of(path, "txt")


def test_a_cover_and_titles_of_a_spreadsheet_are_left_out(tmp_path):
    path = workbook(
        tmp_path / "a.xlsx",
        Cover=[["My game"], ["Version", 2]],
        Script=[["Lines of act one"], HEAD, ["a", "Anna", "Hello."]],
        More=[HEAD, ["b", "Bob", "Bye."]],
    )
    remarks = []
    lines = read(path, remark=remarks.append)
    assert [(x.place, x.text) for x in lines] == [
        (f"{path}:3", "Hello."),
        (f"{path}:More!2", "Bye."),
    ]
    told = "names the columns; the rows above are left out"
    assert remarks == [
        f"{path}:2: {told}",
        f"{path}: left out Cover: the columns differ from those of Script",
    ]
    remarks.clear()
    table = write(tmp_path / "a.csv", "The game;;\n\nid;speaker;text\na;Ann;Hello.\n")
    [line] = read(table, remark=remarks.append)
    assert (line.place, line.text, remarks) == (f"{table}:4", "Hello.", [f"{table}:3: {told}"])


def _quiet(_):
    pass


def _refusal_of(path, column):
    with pytest.raises(LipsyncError) as caught:
        read(path, column=column)
    return str(caught.value)


def test_a_project_states_the_sheet_and_the_row_of_names(tmp_path):
    path = tmp_path / "a.xlsx"
    workbook(
        path,
        Cover=[["name", "The game"], ["id", "7"]],
        Lines=[["Act one", "x"], ["", "y"], ["Who", "Said"], ["Bo", "Hello."]],
        More=[["Who", "Said"], ["Bo", "Bye."]],
    )
    assert texts(path, "Lines", 3) == ["Hello."]
    assert texts(path, "More", None) == ["Bye."]
    with pytest.raises(LipsyncError, match=r"has no sheet 'Nope' with cells\. Its sheets: Cover, "):
        texts(path, "Nope", None)
    with pytest.raises(LipsyncError, match=":9: has no row of column names"):
        texts(path, None, 9)
    table = write(tmp_path / "a.csv", "The game,of maps\n\nWho,Said\nBo,Hello.\n")
    assert texts(table, None, 3) == ["Hello."]
    with pytest.raises(LipsyncError, match=":9: has no row of column names"):
        texts(table, None, 9)


def texts(path, *layout):
    found = read(path, column="Said", layout=TableLayout(*layout), remark=_quiet)
    return [line.text for line in found]


def test_damaged_spreadsheets_are_refused(tmp_path):
    path = workbook(tmp_path / "a.xlsx", One=[HEAD, ["a", "Anna", "Hello."]])
    whole = path.read_bytes()
    assert "spreadsheet cannot be read" in refusal(
        write(tmp_path / "b.xlsx", whole[: len(whole) // 2])
    )
    assert "spreadsheet cannot be read" in refusal(write(tmp_path / "c.xlsx", b"id,text\n"))
    assert "no row of column names" in refusal(workbook(tmp_path / "d.xlsx", One=[]))


def test_spreadsheets_that_unpack_to_gigabytes_are_refused(tmp_path, monkeypatch):
    path = workbook(tmp_path / "a.xlsx", One=[HEAD, ["a", "Anna", "Hello." * 1000]])
    monkeypatch.setattr("lipsync_lang.text.lines.xlsx.MAX_PART_BYTES", 5_000)
    assert "save the script as a table" in refusal(path)
