"""The text of scripts: markup, asides, choices and values, and letters in every form of Unicode."""

import csv
import json
import unicodedata
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from lanes import full
from shipped import LANGUAGES, LIBRARY

from lipsync_lang import LipsyncError
from lipsync_lang.commands.shared_options import cleaning
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.schedules.schedule import Audio, Schedule
from lipsync_lang.sound.speech.hearing.align.aligners import ALIGNERS
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines import read_lines
from lipsync_lang.text.lines.choices import chosen
from lipsync_lang.text.lines.cleaning import Cleaning
from lipsync_lang.text.lines.markup import is_aside, ordinary, spoken
from lipsync_lang.text.phonology.g2p.g2p_engines import Settings
from lipsync_lang.text.phonology.labels import Notation
from lipsync_lang.text.phonology.manner import Manner

PACK = """\
kind: language
format: 1
name: ruled
tag: qaa
g2p: {{engine: rules, letters: ["\u09dc"]}}
notations: {{ipa: {{a: aa, m: bmp}}}}
asides: [{asides}]
"""
HERE = Path(__file__).parent


def asides_of(language):
    return LIBRARY.language(language).model.asides


def dirty_lines():
    with (HERE / "dirty_lines.tsv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


# Markup


@pytest.mark.parametrize(
    ("written", "said", "dropped"),
    [
        ("*sighs* {w}Wait.{w} (gasps) ", "Wait.", ("*sighs*", "{w}", "{w}", "(gasps)")),
        ("{w}Wait{p}for it{p=2}", "Wait, for it", ("{w}", "{p}", "{p=2}")),
        ("Yes.<break/> No", "Yes. No", ("<break/>",)),
        ("What the #@$%! is that?", "What the, is that?", ("#@$%!",)),
        ("$#@%!", "", ("$#@%!",)),
        ("SPY×FAMILY 去你×的 3×4", "SPY FAMILY 去你×的 3×4", ("×",)),
        ("Take the \\left path\\ and\\or C:\\Games \\", "Take the left path and or C: Games", ()),
        ("Hello\\lthere\\nfriend", "Hello there friend", ()),
        ("Wait.[p]Go! Stop.I said.Now", "Wait. Go! Stop. I said. Now", ("[p]",)),
        ("Ph.D. e.g.The S.T.A.R. node.js 3.Of ASP.NET", None, ()),
        ("winst t.o. vorig jaar", None, ()),
        ("<emphasis level='strong'>very</emphasis> good", "*very* good", ()),
        ('the <sub alias="World Wide Web">WWW</sub>', "the World Wide Web", ()),
        ("<#ff0000>red</color> <size=120%>big</size>", "red big",
         ("<#ff0000>", "</color>", "<size=120%>", "</size>")),
        ("<RichColor>x</>", "x", ("<RichColor>", "</>")),
        ("<<if $met>>Hi<<endif>> <!-- x -->", "Hi", ("<<if $met>>", "<<endif>>", "<!-- x -->")),
        ("Hello<br>world<p>you</p>", "Hello world you", ("<br>", "<p>", "</p>")),
        ("Hi {{name}}, %PLAYER%!", "Hi, !", ("{{name}}", "%PLAYER%")),
        (r"\C[2]Hi\C[0] \N[1]\.\|\! you", "Hi you",
         (r"\C[2]", r"\C[0]", r"\N[1]", r"\.", r"\|", r"\!")),
        ("so :D and xD, ;P", "so and,", (":D", "xD", ";P")),
        ("t.o.v. dat T.T", "t.o.v. dat", ("T.T",)),
        ("- no :) xD ^_^ :-( T_T", "no", ("- ", ":)", "xD", "^_^", ":-(", "T_T")),
        ("#{town} @me@ >>> go <<<", "go", ("#{town}", "@me@", ">>>", "<<<")),
        ("at 5:3 (yes: D) 8) -5 degrees", "at 5:3 (yes: D) 8) -5 degrees", ()),
        ("[wave]Hi[/wave] [b=1]you[/b]", "Hi you", ("[wave]", "[/wave]", "[b=1]", "[/b]")),
        ("Go -> DONE", "Go", ("-> DONE",)),
        ("Hi # angry", "Hi", ("# angry",)),
        ("&lt;b&gt;R&amp;amp;D&lt;/b&gt;&nbsp;is &#233;", "R&D is é", ("<b>", "</b>")),
        ("see www.a.org, or a.b@c.org.", "see, or.", ("www.a.org", "a.b@c.org")),
        ("go #teamwork #1", "go #1", ("#teamwork",)),
        ("me🙂you 👨‍👩‍👧 1️⃣", "me you 1", ("🙂", "👨‍👩‍👧", "️⃣")),
        ("Hey~ 好～ すご～い 10～20", "Hey 好 すご～い 10～20", ("~", "～")),
        ("snake_case => a | b", "snake case a b", ("_", "=>", "|")),
    ],
)  # fmt: skip
def test_markup_of_scripts_is_not_spoken(written, said, dropped):
    said = written if said is None else said
    assert spoken(written)[:2] == (said, dropped)


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("*sighs* Whatever.", "Whatever."),
        ("No. *Laughs wildly* You!", "No. You!"),
        ("Well (sighs), okay", "Well, okay"),
        ("(door creaks)", ""),
        ("(MUSIC PLAYING)", ""),
        ("*shrugs* Me?", "Me?"),
        ("I *never* said so", "I *never* said so"),
        ("*please* go", "*please* go"),
        ("Yes, *please*.", "Yes, *please*."),
        ("I *really* *love* it", "I *really* *love* it"),
        ("*whole line*", "*whole line*"),
        ("my friend (my brother) left", "my friend (my brother) left"),
        ("(I wonder.)", "(I wonder.)"),
        ("+50 HP. (max. 3x)", "+50 HP. (max. 3x)"),  # a number is said
        ("(laughs 2 times) Yes.", "Yes."),
    ],
)
def test_asides_are_not_spoken_and_emphasis_is(written, said):
    assert spoken(written, Cleaning(asides=("sigh...", "laugh..."))).text == said


def test_asides_without_capitals_are_told_by_their_words():
    assert is_aside("笑", "", "いいよ", ["笑"])
    assert not is_aside("私の弟が笑って話していたのですよね", "", "", ["笑"])
    assert not is_aside("弟", "", "", ["笑"])


@pytest.mark.parametrize("marks", ["（）", "【】", "〔〕", "［］"])
def test_brackets_of_east_asia_hold_asides_and_words(marks):
    cleaning = Cleaning(asides=("回想",))
    assert spoken(f"{marks[0]}回想{marks[1]}昨日だ。", cleaning).text == "昨日だ。"
    assert (
        spoken(f"{marks[0]}重要{marks[1]}読め。", cleaning).text
        == f"{marks[0]}重要{marks[1]}読め。"
    )


@pytest.mark.parametrize(
    ("written", "said", "known"),
    [
        ("{n, plural, =0 {none} one {# coin} other {# coins}}", "none", "3 coins"),
        ("{n, select, 3 {three} other {many}}", "many", "three"),
        ("{n, plural, one {a {n, select, other {b}}} other {c}}", "c", "c"),
        ("{ $n -> [one] a coin *[other] coins }", "coins", "coins"),
        ("{first|second}", "first", "first"),
        ("{|later} {~a|b}", "later a", "later a"),
        ("{met: Hello again|Hello}", "Hello again", "Hello again"),
        ('{ "literal" }', "literal", "literal"),
    ],
)
def test_one_branch_of_a_choice_is_spoken(written, said, known):
    general = said if "=0" not in written else "coins"
    assert spoken(written).text == general
    assert spoken(written, Cleaning({"n": "3"})).text == known
    assert "{" not in chosen(written.replace("#", ""), {"n": "0"})


def test_placeholders_become_their_values():
    known = Cleaning({"player": "Ada", "0": "zero", "s": "ess"})
    forms = (
        "[player!t] {player} $player ${player} {$player} %(player)s {{player}} %player% <player>"
    )
    written = f"{forms} {{0:>3}} %s {{other}}"
    said = spoken(written, known)
    assert said.text == " ".join(["Ada"] * 9) + " zero ess"
    assert said.dropped == ("{other}",)
    assert spoken("pre[player]s", known).text == "preAdas"


def test_a_project_lists_what_it_does_not_speak():
    listed = Cleaning(unspoken=("NPC_01", "SFX:...", "((...))"))
    assert spoken("NPC_01 Hello ((loud)) you. SFX: boom", listed)[:2] == (
        "Hello you.",
        ("NPC_01", "((loud))", "SFX: boom"),
    )


@pytest.mark.parametrize(
    ("written", "said", "column"),
    [
        ("<b Hello", "b Hello", 1),
        ("Hi {name", "Hi name", 4),
        ("a] b", "a b", 2),
        ("a <b <i>c", "a b c", 3),
    ],
)
def test_a_mark_without_a_partner_is_located(written, said, column):
    found = spoken(written)
    assert found.text == said
    assert f"column {column}:" in found.remarks[0]


@given(st.text(alphabet="ab .<>{}[]()*/\\%$#&;|~_🙂\n1", max_size=30))
@example("&amp;lt;")
@example(";(\\{")
@example("}:) <{3")
def test_cleaning_again_changes_nothing(text):
    once = spoken(text).text.replace("*", "").replace("\\", "")
    assert spoken(spoken(once).text).text == spoken(once).text


def test_dirty_lines_speak_their_words_alone():
    lines = dirty_lines()
    assert len(lines) >= 200
    assert len(Counter(line["language"] for line in lines)) == 13
    for line in lines:
        found = spoken(line["written"], Cleaning(asides=asides_of(line["language"])))
        assert found.text == line["said"], line["written"]
        assert found.dropped or "\\n" in line["written"] or "plural" in line["written"]


@full
def test_long_markup_is_read_in_linear_time():
    parts = ["😀", "{", "<b", "(", "*a", "[a", "a@", "{a|", "&amp;", "x~", "<!--", "{rt}", "(a) ",
             "*a* ", "<sub ", "# a ", "\\", "-> ", "{w}", "[a]", "\n", "\0", "}",
             "{a, plural, one {"]  # fmt: skip
    for part in parts:
        found = spoken(part * (60_000 // len(part)), Cleaning(asides=("laugh...",)))
        assert len(found.text) <= 120_000


# Letters


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("u\u0308ber", "über"),
        ("５０％ ＨＰ", "50% HP"),
        ("３．５", "3.5"),
        ("ﾊﾞﾅﾅ", "バナナ"),
        ("l\u02bcami don\u2019t ng\u02bcombe", "l'ami don't ng'ombe"),
        ("\u2018hello\u2019", "\u2018hello\u2019"),
        ("ﬁn 𝐇𝐢 ② ５㎏ ⁉", "fin Hi 2 5kg !?"),
        ("ﻣﺮﺣﺒﺎ", "مرحبا"),
        ("\u202bab\u202c c\u00ado", "ab co"),
        ("ไทย\u200bคำ", "ไทย\u200bคำ"),
    ],
)
def test_letters_are_ordinary(written, said):
    assert ordinary(written) == said


@given(st.text())
def test_ordinary_letters_stay(text):
    assert ordinary(ordinary(text)) == ordinary(text)


def widened(text):
    return "".join(chr(ord(c) + 0xFEE0) if "!" <= c <= "~" else c for c in text)


@full
def test_tests_of_packs_are_the_same_text_in_every_form():
    for pack in LANGUAGES:
        for one in LIBRARY.language(pack).model.tests:
            plain = spoken(one.text).text
            assert spoken(unicodedata.normalize("NFD", one.text)).text == plain
            assert spoken(widened(one.text)).text == plain


# Speakers

TABLE = {"a": (("aa", 1.0),), "m": (("bmp", 1.0),), "ড়": (("d", 1.0),)}
RULED = Manner(
    "ruled",
    "rules",
    Settings("ruled", labels=tuple(TABLE)),
    notation="ipa",
    durations={"silence": 0.3, "stop": 0.1},
    asides=("gasp...",),
    letters={unicodedata.normalize("NFC", "ড়"): "ড়"},
)


def speaker(**how):
    return Speaker(RULED, {"ipa": Notation(TABLE)}, cleaning=Cleaning(**how))


def test_reading_and_speaking_clean_alike():
    written = "<b>ma</b> [who] (gasps) *am* 🙂"
    (read,) = speaker(values={"who": "mam"}).transcribe([written])
    said = speaker(values={"who": "mam"}).speak(written)
    assert [word.text for word in read.words if word.labels] == ["ma", "mam", "am"]
    assert [(word.text, word.emphasis) for word in said.words] == [("ma", 0), ("mam", 0), ("am", 1)]
    assert read.dropped == said.dropped == ("<b>", "</b>", "(gasps)", "🙂")


def test_a_text_of_markup_alone_is_rest():
    said = speaker().speak("(gasps)")
    assert (said.labels, said.dropped, said.end) == (("_",), ("(gasps)",), 0.3)
    said = speaker().speak("...")
    assert (said.labels, said.dropped, said.end) == (("_",), (), 0.3)
    with pytest.raises(LipsyncError, match="says nothing"):
        speaker().speak("")


def test_an_engine_gets_the_letters_that_it_reads():
    (read,) = speaker().transcribe([unicodedata.normalize("NFC", "ড়a")])
    assert read.labels == ("ড়", "a")


def test_a_mark_without_a_partner_is_told_of_the_line():
    assert "column 4:" in speaker().speak("ma {am").remarks[0]


def test_a_value_names_its_placeholder():
    class Options:
        values, unspoken = ["who=a=b"], ("x",)

    assert cleaning(Options()) == Cleaning({"who": "a=b"}, ("x",))
    Options.values = ["who"]
    with pytest.raises(LipsyncError, match="write NAME=TEXT"):
        cleaning(Options())


def test_a_corpus_counts_what_is_spoken(tmp_path):
    (tmp_path / "a.txt").write_text("<b>ma</b> [who] {x} (gasps) am\n")
    (line,) = read_lines(tmp_path / "a.txt", cleaning=Cleaning({"who": "mam"}))
    assert (line.text, line.dropped) == ("ma mam (gasps) am", ("<b>", "</b>", "{x}"))
    (tmp_path / "ruled.yaml").write_text(PACK.format(asides="gasp..."), "utf-8")
    found = coverage([line], tmp_path / "ruled.yaml", "crab")
    assert {one.what for one in found.corpus.dropped} == {"<b>", "</b>", "{x}", "(gasps)"}


def test_a_pack_states_the_letters_of_its_engine(tmp_path):
    (tmp_path / "ruled.yaml").write_text(PACK.format(asides="gasp..."), "utf-8")
    stated = Speaker.of(tmp_path / "ruled.yaml").manner.letters
    assert stated == {"\u09a1\u09bc": "\u09dc"}


def test_an_aligner_gets_what_is_spoken(monkeypatch):
    class Recorder:
        def align(self, audio, text, speaker, model=None):  # noqa: ARG002 as aligners are called
            heard.append(text)
            return Schedule(("m",), [0.0, 1.0], audio=audio, confidence=1.0)

    heard: list[str] = []
    monkeypatch.setitem(ALIGNERS.known, "recorder", Recorder())
    sound = Audio(np.zeros(16000, np.int16), 16000)
    found = aligned(speaker(values={"who": "am"}), sound, "<b>ma</b> [who]", aligner="recorder")
    assert heard == ["ma am"]
    assert found.dropped == ("<b>", "</b>")
    rest = aligned(speaker(), sound, "(gasps)", aligner="recorder")
    assert (rest.labels, rest.end, rest.audio) == (("_",), 1.0, sound)


def test_commands_take_values_and_the_list_of_the_project(tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ruled.yaml").write_text(PACK.format(asides="gasp..."), "utf-8")
    (tmp_path / "lipsync.yaml").write_text(
        "kind: project\nformat: 1\nunspoken: NPC\nvalues: {who: am, where: ma}\n"
    )
    text = "NPC ma [who] [where] [when]"
    given = ("-l", "ruled.yaml", "--value", "who=mam")
    read = json.loads(cli("transcribe", text, *given, "--json").out)
    assert (read[0]["text"], read[0]["dropped"]) == ("ma mam ma", ["NPC", "[when]"])
    told = cli("run", text, *given, "-c", "crab", "--tts", "none").err
    assert "not spoken: NPC [when]" in told
    assert "3 words" in told
