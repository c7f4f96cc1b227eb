"""The pages that set this program beside the paper: made from the packs and its figures."""

import importlib
import json
import re
import shlex
import sys

import pytest
from lanes import full, needs_plug_ins
from places import ROOT

from lipsync_lang.cli import main, parser
from lipsync_lang.commands.registry import leaves

MODULES = ("the_paper", "how_good")


@pytest.fixture(scope="module")
def the_paper():
    """Import the script of the pages, which counts once, and unload it afterwards."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "docs")
        yield importlib.import_module("the_paper")
    for name in MODULES:
        sys.modules.pop(name, None)


@full
def test_the_pages_are_what_the_packs_make(the_paper):
    for path in the_paper.PAGES:
        assert the_paper.page(path) == path.read_text("utf-8"), "run python docs/the_paper.py"


def test_every_mark_is_a_part_and_every_part_has_its_mark(the_paper):
    texts = [path.read_text("utf-8") for path in the_paper.PAGES]
    names = [name for text in texts for name in re.findall(r"<!-- made: (\w+) -->", text)]
    assert sorted(names) == sorted(the_paper.BLOCKS)


def test_table_2_is_printed_in_its_order_and_adds_up(the_paper):
    printed = [*the_paper.PAPER["table_2"].values()]
    assert printed == sorted(printed, reverse=True)
    assert len(printed) == 21
    assert sum(printed) == pytest.approx(36.79)


def nearer_to_table_2(the_paper, corpus):
    """Tell whether the paper's mapping is nearer to Table 2 than the default one."""
    likeness = {name: one.likeness() for name, one in the_paper.counted(corpus).items()}
    paper, default = likeness["paper-english"], likeness["english"]
    return paper[1] < default[1] and paper[2] > default[2]


def test_the_papers_mapping_is_nearer_to_table_2(the_paper):
    assert nearer_to_table_2(the_paper, "dialogue")


@full
def test_the_papers_mapping_is_nearer_to_table_2_in_every_corpus(the_paper):
    assert all(nearer_to_table_2(the_paper, corpus) for corpus in the_paper.corpora())


def test_counts_are_those_of_the_text(the_paper):
    one = the_paper.counted("dialogue")["english"]
    assert sum(one.counts.values()) == one.total
    assert one.unused + len(one.counts) == 441
    assert one.first(len(one.counts)) == pytest.approx(100)
    assert one.first(one.needed(90)) >= 90 > one.first(one.needed(90) - 1)


# The items


def listed(the_paper):
    return [item for section in the_paper.ITEMS for item in section["items"]]


def commands(the_paper):
    """The commands of the page, each once, with one of our texts as the corpus."""
    corpus = str(the_paper.DOCS / "corpora" / "the-question.txt")
    found = dict.fromkeys(item["see"] for item in listed(the_paper) if "see" in item)
    return [shlex.split(one.replace("CORPUS", shlex.quote(corpus))) for one in found]


def test_every_item_can_be_seen(the_paper):
    for item in listed(the_paper):
        assert {*item} <= {"says", "here", "see", "file", "differs"}, item
        assert {"see", "file"} & {*item}, item


@full
def test_every_figure_and_table_of_the_paper_is_an_item(the_paper):
    page = the_paper.items()
    for number in range(1, 14):
        assert re.search(rf"\|.*\bFigure {number}\b.*\|", page), number
    for number in (1, 2):
        assert re.search(rf"\|.*\bTable {number}\b.*\|", page), number
    for number in ("104", "283", "99.1", "2,205", "37.5", "44.14", "23.12", "10.58", "30.42", "43"):
        assert number in page


@needs_plug_ins
def test_every_command_of_an_item_is_one(the_paper):
    whole = parser()
    known = {path for path, _ in leaves(whole)}
    for command in commands(the_paper):
        if command[-1] == "--help":
            assert tuple(command[:-1]) in known, command
        else:
            whole.parse_args(command)


@full
def test_every_command_of_an_item_runs(the_paper, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for command in commands(the_paper):
        if command[-1] != "--help":
            assert main(command) == 0, (command, capsys.readouterr())


def test_every_file_of_an_item_is_made(the_paper):
    made = (ROOT / "docs" / "draw_paper.py").read_text("utf-8")
    for name in {item["file"] for item in listed(the_paper) if "file" in item}:
        number = re.fullmatch(r"figure-(\d+)\.png", name)
        assert f'"{name}"' in made or (number and f'("{number[1]}", ' in made), name


@full
def test_measured_figures_are_those_that_are_kept(the_paper):
    kept = json.loads((the_paper.DOCS / "measured.json").read_text("utf-8"))
    shut = kept["motion-paper"]["figures"]["posesets"]["facefx"]["shut %"]
    assert the_paper.computed().shut_paper == f"{shut:.0f} %"
