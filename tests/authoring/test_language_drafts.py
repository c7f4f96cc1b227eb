"""Drafting, showing and trying language packs."""

import gzip
import json
import re
from pathlib import Path

import pytest
from lanes import full

from lipsync_lang.authoring.language_draft import LanguageWish, _entry, draft, read_inventory
from lipsync_lang.authoring.trial import languages_in, try_out
from lipsync_lang.base.errors import LipsyncError, PackError
from lipsync_lang.base.presentation.text_table import columns, width
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.nearest_phonemes import among_all
from lipsync_lang.text.phonology.nearest import Nearest

PHOIBLE = """\
InventoryID,Glottocode,ISO6393,LanguageName,Source,Phoneme
7,abcd1234,tst,Testish,spa,p
7,abcd1234,tst,Testish,spa,k͡p
7,abcd1234,tst,Testish,spa,y
7,abcd1234,tst,Testish,spa,ɬ
7,abcd1234,tst,Testish,spa,a
7,abcd1234,tst,Testish,spa,˥
8,abcd1235,oth,Other,upsid,m
9,abcd1235,oth,Other,ph,m
"""

PACK = """\
kind: language
format: 1
name: toy
tag: qaa
g2p: {engine: rules, rules: [{from: c, to: k, before: e}, {from: q, to: k}]}
notations: {ipa: {a: ah, e: eh, k: kg, p: bmp, s: s}}
examples: {k: kep, s: sap}
reasons: {s: teeth together}
caveats: [It reads no numbers.]
inventory: {source: nobody, segments: [a, e, k, p, s, ʔ], absent: {ʔ: not written}}
tests:
  - {text: kapa, ipa: k a p a, phonemes: [kg, ah, bmp, ah], source: me}
  - {text: ce, ipa: k e, phonemes: [kg, eh], source: me}
"""


def put(folder, name, text):
    """Write a language into a project."""
    path = folder / "languages" / f"{name}.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, "utf-8")
    return path


# Inventories


def test_phoibles_table_is_read_by_number_code_and_name(folder):
    file = folder / "phoible.csv"
    file.write_text(PHOIBLE, "utf-8")
    for which in ("7", "tst", "testish"):
        found = read_inventory(file, which)
        assert found.segments == ("p", "k͡p", "y", "ɬ", "a", "˥")
        assert found.source == "PHOIBLE 7 (spa, Testish)"
    packed = folder / "phoible.tsv.gz"
    packed.write_bytes(gzip.compress(PHOIBLE.replace(",", "\t").encode()))
    assert read_inventory(packed, "7").segments == found.segments


@pytest.mark.parametrize(
    ("content", "which", "message"),
    [
        (PHOIBLE.encode(), None, r"holds 3 inventories; name one by number"),
        (PHOIBLE.encode(), "tset", r"has no inventory 'tset'; did you mean 'tst'"),
        (
            PHOIBLE.encode(),
            "oth",
            r"several inventories match 'oth'; name one: 8 \(1 segments\)",
        ),
        (b"", None, r"has no segments; write them with spaces"),
        (b"\xff", None, r"is not UTF-8 text \(byte 0\)"),
        (b"\x1f\x8bbroken", None, r"is a broken gzip file"),
    ],
)
def test_bad_inventories_are_messages(folder, content, which, message):
    file = folder / "inventory.csv"
    file.write_bytes(content)
    with pytest.raises(LipsyncError, match=message):
        read_inventory(file, which)
    with pytest.raises(LipsyncError, match="cannot be read"):
        read_inventory(folder / "none.csv")


# Drafts


@full
def test_a_draft_of_an_inventory_runs_and_names_its_doubts(folder, cli):
    (folder / "phoible.csv").write_text(PHOIBLE, "utf-8")
    ended = cli("languages", "new", "testish", "--inventory", "phoible.csv", "--inventory-id", "7")
    assert ended.code == 0, ended.err
    assert "wrote languages/testish.yaml: 6 labels, " in ended.err
    text = (folder / "languages" / "testish.yaml").read_text("utf-8")
    assert text.index("# Doubtful") < text.index("# Listed by common phonemes")
    pack = Library().language("testish").model
    assert pack.tag == "tst"
    assert [*pack.adds] == ["yu"]
    assert pack.inventory.absent == {"˥": "it is not visible"}
    assert pack.notations["ipa"]["k͡p"].to == ("bmp",)
    assert cli("validate", "languages/testish.yaml").code == 0
    ended = cli("run", "papa kp", "-l", "testish", "-c", "facefx", "-o", "out.csv")
    assert ended.code == 0, ended.err
    assert Path("out.csv").exists()


def test_a_draft_of_a_lexicon_takes_it_along(folder, cli):
    lexicon = folder / "words.txt"
    lexicon.write_text("hus\th ʉː s\nøl\tø l\nkylling\tç y l ɪ ŋ\n", "utf-8")
    made = draft(Library(), LanguageWish("nordic", tag="qaa", lexicon=lexicon))
    assert not (folder / "languages").exists(), "drafting alone writes nothing"
    made.write()
    assert "nordic.txt" in str(made)
    assert (folder / "languages" / "nordic.txt").read_bytes() == lexicon.read_bytes()
    pack = Library().language("nordic").model
    assert pack.examples["ʉː"] == "hus"
    assert pack.notations["ipa"]["ø"].to == ("oe",)
    assert cli("transcribe", "øl hus", "-l", "nordic").code == 0
    assert cli("validate", "languages/nordic.yaml").code == 0


@pytest.mark.parametrize("source", ["profile", "lexicon"])
@pytest.mark.parametrize("suffix", [".yaml", ".YAML"])
def test_a_draft_is_not_replaced_by_a_source_with_the_suffix_of_a_pack(folder, source, suffix):
    table = folder / f"table{suffix}"
    table.write_text("Grapheme\tIPA\na\ta\n", "utf-8")
    with pytest.raises(LipsyncError, match=rf"table\{suffix}: has the suffix of a pack; .* \.tsv"):
        draft(Library(), LanguageWish("valley", **{source: table}))


@full
def test_a_draft_of_a_voice_hears_its_numbers(folder, cli):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    (folder / "lines.txt").write_text("Góðan daginn\n", "utf-8")
    ended = cli("languages", "new", "icelandic", "--voice", "is", "--text", "lines.txt")
    assert ended.code == 0, ended.err
    pack = Library().language("icelandic").model
    assert len(pack.notations["ipa"]) > 20
    assert "Góðan" in pack.examples.values()
    assert cli("validate", "languages/icelandic.yaml").code == 0


@full
def test_a_draft_of_a_code_reads_by_it(folder, cli):
    pytest.importorskip("epitran", reason="the epitran extra is not installed")
    (folder / "lines.txt").write_text("molo ngqangi\n", "utf-8")
    ended = cli("languages", "new", "my-xhosa", "--epitran", "xho-Latn", "--text", "lines.txt")
    assert ended.code == 0, ended.err
    assert Library().language("my-xhosa").model.tag == "xho"
    assert cli("run", "molo", "-l", "my-xhosa", "-c", "facefx", "-o", "out.csv").code == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "name the new language"),
        (["../evil", "--inventory", "i.txt"], "cannot be a pack's name"),
        (["new"], "needs a source"),
        (["taken", "--inventory", "i.txt"], "already exists"),
        (["english", "--inventory", "i.txt"], "there is a language 'english' already"),
        (["new", "--inventory", "none.txt"], "cannot be read"),
        (["new", "--epitran", "xho-Latn"], "give sample lines"),
        (["new", "--lexicon", "i.txt", "--profile", "i.txt"], "read the same text"),
        (["new", "--profile", "i.txt"], "Grapheme"),
        (["new", "--lexicon", "i.txt", "--epitran", "xho-Latn", "--text", "i.txt"], "one of them"),
    ],
)
def test_what_cannot_be_drafted_is_a_message_and_writes_nothing(folder, cli, arguments, message):
    (folder / "i.txt").write_text("p a", "utf-8")
    put(folder, "taken", "kept")
    ended = cli("languages", "new", *arguments)
    assert ended.code == 2
    assert message in ended.err
    assert [p.name for p in (folder / "languages").iterdir()] == ["taken.yaml"]
    assert (folder / "languages" / "taken.yaml").read_text() == "kept"


def test_an_existing_pack_is_never_written_over(folder):
    put(folder, "taken", "kept")
    with pytest.raises(PackError, match="already exists"):
        draft(Library(), LanguageWish("taken", inventory=Path("x")))


# Trials


def test_tests_that_fail_are_faults_at_their_place(folder, cli):
    path = put(folder, "toy", PACK.replace("[kg, eh]", "[kg, ah]").replace("ipa: k e, ", ""))
    ended = cli("validate", str(path))
    assert ended.code == 1
    assert ended.out.splitlines() == [
        "languages/toy.yaml:13:5: P221 'ce' becomes kg eh, not kg ah",
        "  hint: the engine read k e; correct the map or the test",
    ]
    assert cli("validate", str(path), "--no-tests").code == 0


@pytest.mark.parametrize(("read", "code"), [("[kg, eh]", 0), ("[kg, ah]", 1)])
def test_an_engine_may_differ_from_the_source_as_a_test_states(folder, cli, read, code):
    """The source says an "a", and its own phonemes follow; the engine reads "e"."""
    text = PACK.replace("[kg, eh]", f"[kg, aa], read: {read}").replace("ipa: k e, ", "")
    assert cli("validate", str(put(folder, "toy", text))).code == code


def test_a_trial_knows_what_it_reached(folder):
    put(folder, "toy", PACK.replace("s: s}}", "s: s}, x: {o: ao}}"))
    pack = Library().language("toy")
    trial = try_out(Library(), pack)
    assert not list(trial.faults("_"))
    assert trial.silent_rules() == [1]
    assert {"k", "a", "p", "e"} <= trial.reached


def test_tests_that_cannot_be_run_are_a_warning(folder, cli):
    path = put(folder, "toy", PACK.replace("engine: rules,", "engine: lexicon,"))
    ended = cli("validate", str(path))
    assert ended.code == 0
    assert "W310 warning: its tests could not be run" in ended.out
    assert "names none" in ended.out


def test_languages_are_found_in_files_folders_and_everywhere(folder):
    path = put(folder, "toy", PACK)
    put(folder, "broken", "kind: language\n")
    for where in ([path], [folder], [path.parent]):
        assert [p.model.name for p in languages_in(Library(), where)] == ["toy"]
    assert [p.model.name for p in languages_in(Library())] == ["toy"], "built-in packs are tested"


def test_mappings_that_fight_the_features_of_their_sounds_are_warned_of(folder, cli):
    path = put(folder, "toy", PACK.replace("p: bmp", "p: h").replace("bmp, ah]", "h, ah]"))
    ended = cli("validate", str(path))
    told = "W309 warning: 'p' becomes h, which contradicts its features: closure"
    assert ended.out.splitlines() == [
        f"languages/toy.yaml:6:40: {told}",
        "  hint: correct it, or give the reason under `reasons`",
    ]
    put(folder, "toy", path.read_text("utf-8").replace("reasons: {", "reasons: {p: whispered, "))
    assert cli("validate", str(path)).out == ""


# Tables


def test_a_language_is_shown_as_table_1(folder, cli):
    put(folder, "toy", PACK)
    shown = cli("languages", "show", "toy").out
    assert shown.splitlines()[:3] == [
        "toy (qaa), languages/toy.yaml",
        "reads text with rules, 2 rules",
        "note: It reads no numbers.",
    ]
    assert "  k        kg      kep" in shown
    assert "  s        s       sap      teeth together" in shown
    assert "  absent: ʔ (not written)" in shown
    assert ["kg", "0.15", "0.045", "0.8", "-"] in [*map(str.split, shown.splitlines())], "mouths"
    assert ["s", "0.19", "0.015", "-", "0"] in [*map(str.split, shown.splitlines())]
    assert "2 tests\n  untested phonemes: s\n  untested common phonemes: s\n" in shown
    assert "  untested rules: q" in shown
    told = json.loads(cli("languages", "show", "qaa", "--json").out)
    assert told["tests"]["untested"] == {
        "phonemes": ["s"], "common phonemes": ["s"], "rules": ["q"],
    }  # fmt: skip


def test_columns_stand_below_each_other_in_every_script():
    rows = list(columns([("ab", "x"), ("日本", "y"), ("e\u0301", "z")]))
    assert [width(row.partition(last)[0]) for row, last in zip(rows, "xyz", strict=True)] == [6] * 3


def test_a_remark_beside_a_long_label_has_its_space():
    found = Nearest((("aa", 0.5), ("ih", 0.5)), ("length",), 0.2, ())
    assert _entry("a long label", found) == "    a long label: [aa, ih], # loses length"


def test_a_hint_for_a_sound_names_the_mouth_that_a_draft_gives_it(folder, cli):
    library = Library(project=None)
    common, near = library.common().model, among_all(library)
    known = {**common.phonemes, **common.shades}
    sounds = {one for sound in known.values() for one in sound.ipa} - {*known}
    asked = sorted(one for one in sounds if re.fullmatch("[a-z]+", one))
    assert "i" in asked
    head = {"kind": "language", "format": 1, "name": "toy", "tag": "qaa"}
    added = sorted({*common.phonemes} - {*common.base, common.silence})
    mapped = {"ipa": {f"x{number}": [one] for number, one in enumerate(asked)}}
    put(folder, "toy", json.dumps({**head, "adds": added, "notations": mapped}, ensure_ascii=False))
    told = dict(re.findall(r"unknown phoneme '(.+)'\n  hint: (.+)", cli("validate").out))
    assert told == {one: f"write '{near.value(one)[0][0]}' for it" for one in asked}
