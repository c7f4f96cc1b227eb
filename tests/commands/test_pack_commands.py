"""Commands on packs: resolve, validate, schema, lists, formats and drafts of bigrams."""

import json
import re

import pytest
from command_line import PAIR, listed, refused
from lanes import full, swept

pytestmark = pytest.mark.usefixtures("folder")


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
    assert "441 bigrams without curves:\n  ah-  ah aa ao" in ended.out
    assert max(map(len, ended.out.splitlines())) < 120
    command = ("run", "-l", "english", "-c", "bare", "--schedule", "line.json")
    named = r"3 bigrams of this line: h-ah, ah-l, l-ow"
    told = rf"bare has no curves for {named}\. Draw them.* targets .*--gaps rest"
    refused(cli(*command), told)
    ended = cli(*command, "--gaps", "rest")
    assert ended.code == 0
    assert "3 bigrams without curves at rest: h-ah, ah-l, l-ow" in ended.err


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


HERO = "kind: character\nformat: 1\nname: hero\nposeset: facefx\n# the end\n"


def test_a_draft_goes_into_the_file_of_one_character(cli, folder):
    path = folder / "characters" / "hero.yaml"
    path.parent.mkdir()
    path.write_text(HERO)
    whose, hero = ("-l", "english", "-c", "hero"), str(path.relative_to(folder))
    ended = cli("bank", "draft", *whose, "l-ow", "--write")
    assert "all characters of facefx use them; for this one alone, give --to " + hero in ended.err
    ended = cli("bank", "draft", *whose, "l-ow", "--to", hero)
    assert (ended.code, ended.err) == (0, f"1 drafted bigram put into {hero}\n")
    text = path.read_text("utf-8")
    assert text.startswith(HERO.partition("#")[0])
    assert "# the end" in text
    layers = json.loads(cli("resolve", *whose, "--json").out)["layers"]
    assert layers["character"]["drafted"] == 1
    assert "0 drafted bigrams" in cli("bank", "draft", *whose, "l-ow", "--to", hero).err
    assert path.read_text("utf-8") == text
    ended = cli("bank", "draft", *whose, "l-ow", "--to", "own.yaml")
    assert f"no character uses the file yet; state `banks: [../own.yaml]` in {hero}" in ended.err


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("bank.json", "bank.json: is not a name for a bank; use a name that ends in .yaml"),
        ("line.json/bank.yaml", "line.json: cannot be written: (File exists|Not a dir)"),
        ("english.yaml", "english.yaml: is neither a bank nor a character of facefx; name another"),
        ("list.yaml", "list.yaml"),
        ("folder.yaml", "folder.yaml: "),
        ("other.yaml", "other.yaml: is neither a bank nor a character of facefx"),
        ("broken.yaml", "broken.yaml:1:7: P008"),
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
