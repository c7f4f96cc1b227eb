"""The pages that set this program beside the paper: made from the packs and its figures."""

import importlib
import re
import sys

import pytest

MODULES = ("the_paper", "how_good")


@pytest.fixture
def the_paper(root, monkeypatch):
    """Import the script of the pages, and unload it afterwards."""
    monkeypatch.syspath_prepend(root / "docs")
    yield importlib.import_module("the_paper")
    for name in MODULES:
        sys.modules.pop(name, None)


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


def test_the_papers_mapping_is_nearer_to_table_2_in_every_corpus(the_paper):
    for corpus in the_paper.corpora():
        likeness = {name: one.likeness() for name, one in the_paper.counted(corpus).items()}
        assert likeness["paper-english"][1] < likeness["english"][1]
        assert likeness["paper-english"][2] > likeness["english"][2]


def test_counts_are_those_of_the_text(the_paper):
    one = the_paper.counted("dialogue")["english"]
    assert sum(one.counts.values()) == one.total
    assert one.unused + len(one.counts) == 441
    assert one.first(len(one.counts)) == pytest.approx(100)
    assert one.first(one.needed(90)) >= 90 > one.first(one.needed(90) - 1)
