"""Languages without a pack, which engines and the features of the IPA serve."""

import subprocess
import sys
from dataclasses import replace

import pytest
from lanes import full
from packs_tree import put
from shipped import LIBRARY
from test_ipa import COMMON, ROUND

import lipsync_lang as ll
from lipsync_lang.packs.automatic import IPA_ENGINES, automatic
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.performing.label_reader import label_remarks
from lipsync_lang.resolver import cache
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.labels import Notation, recognise


def schedule(*labels, **rest):
    return ll.Schedule(labels, [0.1 * n for n in range(len(labels) + 1)], **rest)


def spoken(performer, line):
    """The common phonemes of a schedule."""
    return [performer.compiled.phonemes[n] for n in performer.common_phonemes(line)[0]]


@pytest.mark.parametrize(
    ("name", "tag", "engine", "field", "voice"),
    [
        ("espeak:sw", "sw", "espeak", "voice", "sw"),
        ("espeak:en-gb-x-rp", "en-gb-x-rp", "espeak", "voice", "en-gb-x-rp"),
        ("espeak:zh_yue+f3", "zh-yue", "espeak", "voice", "zh_yue+f3"),
        ("epitran:amh-Ethi", "amh-Ethi", "epitran", "code", None),
        ("ipa:lg", "lg", "ipa", "code", None),
    ],
)
def test_a_code_is_a_language(name, tag, engine, field, voice):
    pack = Library(project=None).language(name)
    model = pack.model
    assert (model.name, model.tag, model.automatic) == (name, tag, True)
    assert (model.g2p.engine, getattr(model.g2p, field)) == (engine, name.partition(":")[2])
    assert model.g2p.notation == IPA
    assert (model.tts.voice if model.tts else None) == voice
    assert {*COMMON.base, *model.adds, COMMON.silence} == set(COMMON.phonemes)
    assert "automatic" in model.title
    assert pack.lineage == (name,)


@pytest.mark.parametrize(
    "name",
    ["espeak:", "espeak", ":sw", "rules:x", "espeak:../x", "espeak:a b", "espeak:a:b", "x:y"],
)
def test_what_is_no_code_is_no_language(name):
    assert automatic(name, LIBRARY.common) is None
    with pytest.raises(ll.PackError, match="unknown language"):
        Library(project=None).language(name)


def test_an_unknown_engine_names_those_there_are():
    with pytest.raises(ll.PackError, match=r"espeak:CODE or epitran:CODE or ipa:CODE"):
        Library(project=None).language("especk:sw")
    assert set(IPA_ENGINES) == {"espeak", "epitran", "ipa"}


def test_timed_ipa_of_any_language_is_performed_and_text_is_ipa():
    performer = ll.resolve("ipa:lg", "facefx")
    line = schedule("m", "ʊ", "ɲ", "dʒ", "aː", notation="ipa")
    assert spoken(performer, line)[:4] == ["bmp", "uh", "n", "ch"]
    assert spoken(replace(performer, shades=False), line)[:4] == ["bmp", "w", "d", "sh"]
    assert performer.perform(line)["PBM"].max() >= 0.8
    (said,) = Speaker.of("ipa:lg").transcribe(["mʊɲ dʒaː, ˈka.ta!"])
    assert [(one.text, one.labels) for one in said.words] == [
        ("mʊɲ", ("m", "ʊ", "ɲ")), ("dʒaː", ("d", "ʒ", "a:")), (",", ()),
        ("ˈka.ta", ("k", "a", "t", "a")),
    ]  # fmt: skip
    assert spoken(performer, ll.speak("mʊɲ", "ipa:lg"))[-3:] == ["bmp", "uh", "n"]
    with pytest.raises(ll.LipsyncError, match="not IPA: O"):
        performer.perform(ll.speak("Oli otya", "ipa:lg"))


def test_such_a_language_resolves_and_says_so():
    performer = ll.resolve("espeak:sw", "facefx")
    report = performer.report
    assert report.automatic
    assert "automatic" in str(report).split("\n")[1]
    assert not report.gaps
    assert (report.language, performer.language) == ("espeak:sw", "espeak:sw")
    assert not ll.resolve("english", "facefx").report.automatic
    line = schedule("k͡p", "a", "_", "ⁿd", "iː", "yː", "˥", "sil", "tɬ", notation="ipa")
    assert spoken(performer, line) == ["bmp", "aa", "_", "d", "iy", "yu", "_", "d", "l"]
    weights = performer.perform(line).weights
    assert 0 <= weights.min() <= weights.max() <= 1


def test_a_performer_tells_what_it_mapped_by_features():
    performer = ll.resolve("espeak:sw", "facefx")
    told = performer.automatic(schedule("tʰ", "a", "_", "tʰ", "ɬ", notation="ipa"))
    assert list(told) == ["tʰ", "a", "ɬ"]
    assert told["tʰ"].value == (("d", 1.0),)
    assert told["tʰ"].losses == ("aspiration",)
    assert told["ɬ"].distance > 0
    assert ll.resolve("english", "facefx").automatic(schedule("t", notation="ipa")) == {}


def test_unknown_ipa_may_go_to_the_nearest_in_any_language():
    performer = ll.resolve("english", "facefx")
    line = schedule("ɓ", "ɯ", notation="ipa")
    with pytest.raises(ll.ScheduleError, match="`unknown='nearest'`"):
        replace(performer, unknown="error").perform(line)
    assert spoken(performer, line) == ["bmp", "ih"]
    assert list(performer.automatic(line)) == ["ɓ", "ɯ"]
    for odd in (schedule("ɓ", "Q", notation="ipa"), schedule("ɓ", "a", notation="sampa")):
        with pytest.raises(ll.ScheduleError):
            performer.perform(odd)


def test_a_label_that_no_pack_lists_is_told_once_with_what_it_becomes():
    performer = ll.resolve("english", "facefx")
    line = schedule("ʙ", "i", "ɬ", "ʙ", notation="ipa", source="a.csv")
    what = "is not a sound of english; it is performed as"
    assert label_remarks(performer.labels, line) == (
        f"a.csv: 'ʙ' (2 times) {what} bmp, the nearest by phonetic features",
        f"a.csv: 'ɬ' {what} l, the nearest by phonetic features",
    )
    assert label_remarks(performer.labels, schedule("t", "i", notation="ipa")) == ()
    assert performer.notation(replace(line, notation=None)) is performer.labels.notations["ipa"]
    many = [*"ʙɬɓɗʄɠʛǃǂǁʘꞎ"]
    told = label_remarks(performer.labels, schedule(*many, notation="ipa", source="a.csv"))
    assert told[-1] == "a.csv: 4 more labels are performed by their phonetic features"
    numbers, _, _ = performer.common_phonemes(schedule("B\\", notation="x-sampa"))
    assert [performer.compiled.phonemes[n] for n in numbers] == ["bmp"]


def test_only_what_may_be_one_sound_goes_to_the_nearest():
    labels = ll.resolve("german", "facefx").labels
    ipa = labels.notations["ipa"]
    sounds = ["ʙ", "tɬ", "ndʒ", "k͡p", "jaʊ", "ɛɹ", "ŋǃ", "q͡χʼ", "t̪s̪ʰʷ", "ʷ", "ɯɯ"]
    assert [one for one in sounds if labels.unlisted(ipa, one) is None] == []
    words = ["hello", "the", "no", "word", "strength", "bla", "nz", "brr", "QZ", "你", "3", ""]
    numbers = ["f000001", "ʙ00001", "123456"]
    assert [one for one in (*words, *numbers) if labels.unlisted(ipa, one) is not None] == []
    assert [one for one in numbers if ipa.find(one) is not None] == []


def test_what_is_no_ipa_stays_an_error_or_rests():
    performer = ll.resolve("espeak:sw", "facefx")
    line = schedule("a", "tQ", notation="ipa")
    with pytest.raises(ll.ScheduleError, match=r"'tQ'.*not IPA: Q"):
        performer.perform(line)
    resting = ll.Performer(performer.compiled, performer.motion, unknown="rest")
    assert spoken(resting, line) == ["aa", "_"]
    assert list(resting.automatic(line)) == ["a"]


def test_a_pack_with_a_map_is_told_what_is_nearest():
    line = schedule("ʙ", "ts", notation="ipa")
    performer = ll.resolve("english", "facefx", unknown="error")
    with pytest.raises(ll.ScheduleError) as caught:
        performer.perform(line)
    assert "nearest by its features: bmp" in str(caught.value)
    assert "nearest by its features: d s" in str(caught.value)
    with pytest.raises(ll.ScheduleError) as caught:
        ll.resolve("english", "facefx").perform(schedule("XX", notation="arpabet"))
    assert "features" not in str(caught.value)


def test_a_pack_may_leave_the_rest_to_features(tmp_path):
    text = (
        "kind: language\nformat: 1\nname: half\ntag: qaa\nautomatic: true\n"
        "notations: {own: {X: s}, ipa: {t: s, y: w}}\n"
    )
    put(tmp_path, "languages/half.yaml", text)
    performer = ll.resolve("half", "facefx", paths=[tmp_path], cache=False)
    line = schedule("t", "tʰ", "y", "k", "t˥", notation="ipa")
    assert spoken(performer, line) == ["s", "d", "w", "kg", "s"]
    assert list(performer.automatic(line)) == ["tʰ", "k"]
    with pytest.raises(ll.ScheduleError):
        performer.perform(schedule("k", notation="own"))


def test_features_do_not_speak_for_a_notation():
    own, ipa = Notation({"iy": ()}), Notation({"ɬ": ()}, nearest=ROUND.value)
    table = {"own": own, "ipa": ipa}
    assert recognise(["iy", "k"], table) == "own"
    assert recognise(["k", "t"], table) == "ipa"
    assert table["ipa"].stated("k") is None
    assert table["ipa"].find("k") == (("kg", 1.0),)
    assert table["ipa"].find("Q") is None


def test_a_pack_may_extend_a_code(tmp_path):
    text = (
        "kind: language\nformat: 1\nname: mine\ntag: sw\nextends: espeak:sw\n"
        "notations: {ipa: {a: aa}}\nwords: {jambo: [d, ah, bmp, ow]}\n"
    )
    path = put(tmp_path, "languages/mine.yaml", text)
    library = Library([tmp_path], project=None)
    pack = library.language("mine")
    assert (pack.model.name, pack.model.automatic, pack.model.tts.voice) == ("mine", True, "sw")
    assert pack.lineage == ("mine", "espeak:sw")
    assert not [f for f in validate(library, [path]) if f.severity == "fault"]
    performer = ll.resolve("mine", "facefx", paths=[tmp_path], cache=False)
    assert spoken(performer, schedule("a", "aː", "y", notation="ipa")) == ["aa", "aa", "yu"]
    put(tmp_path, "languages/mine.yaml", text.replace("espeak:sw", "especk:sw"))
    with pytest.raises(PackFaults, match="P210 unknown language 'especk:sw'"):
        Library([tmp_path], project=None).language("mine")


CHECK = """
import sys, lipsync_lang as ll
performer = ll.resolve("espeak:sw", "facefx")
line = ll.Schedule(("tɬ",), [0, 1])
print(*(name for name, _ in performer.notation(line).find("tɬ")))
print(*sorted(sys.modules))
"""


@full
def test_a_warm_start_maps_by_features_without_yaml(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path))
    loaded = []
    for _ in range(2):
        command = [sys.executable, "-c", CHECK]
        done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
        said, modules = done.stdout.splitlines()
        assert said == "d l"
        loaded.append(set(modules.split()))
    assert {"ruamel.yaml", "pydantic"} <= loaded[0]
    assert not {"ruamel.yaml", "pydantic"} & loaded[1]


@full
def test_the_cache_notices_another_ipa(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    project = tmp_path / "project"
    project.mkdir()
    monkeypatch.chdir(project)
    for _ in range(2):
        assert spoken(ll.resolve("espeak:sw", "facefx"), schedule("ɬ", notation="ipa")) == ["l"]
    kept = cache.load("espeak:sw", "facefx", ())
    assert kept.nearest == compile_pair(Library(), "espeak:sw", "facefx").nearest
    text = LIBRARY.ipa().path.read_text(encoding="utf-8")
    other = text.replace("ɬ: alveolar lateral fricative", "ɬ: alveolar hissing fricative")
    put(project, "languages/ipa.yaml", other)
    assert cache.load("espeak:sw", "facefx", ()) is None
    assert spoken(ll.resolve("espeak:sw", "facefx"), schedule("ɬ", notation="ipa")) == ["s"]
    put(project, "languages/ipa.yaml", text)
    assert cache.load("espeak:sw", "facefx", ()) is None


def test_a_voice_speaks_without_a_pack():
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    line = ll.speak("Habari ya asubuhi", "espeak:sw")
    performer = ll.resolve("espeak:sw", "facefx")
    assert line.language == "espeak:sw"
    assert "bmp" in spoken(performer, line)
    with pytest.raises(ll.SpeechError, match="qqq"):
        ll.speak("x", "espeak:qqq")
