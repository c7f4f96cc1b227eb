"""`make paper`: every item of the paper that can be made again, from the program as it is."""

import importlib
import json
import re
import sys
from importlib.util import find_spec

import pytest
from lanes import full

MODULES = ("draw_paper", "the_paper", "how_good")
needs = pytest.mark.skipif(
    find_spec("matplotlib") is None, reason='needs matplotlib: pip install "lipsync-lang[plot]"'
)


@pytest.fixture
def draw_paper(root, monkeypatch):
    """Import the script, and unload it afterwards."""
    monkeypatch.syspath_prepend(root / "docs")
    yield importlib.import_module("draw_paper")
    for name in MODULES:
        sys.modules.pop(name, None)


def test_answers_have_the_printed_counts_and_strengths(draw_paper):
    paper = draw_paper.the_paper.PAPER
    study, submissions = draw_paper.answered(paper)
    assert len(study["pairs"]) == 40
    assert len(submissions) == 80
    sides = {pair["pair"]: pair for pair in study["pairs"]}
    for character, printed in paper["study"].items():
        told = {"ours": [], "facefx": []}
        for answer in (answer for one in submissions for answer in one["answers"]):
            pair = sides[answer["pair"]]
            if pair["character"] == character:
                told[pair[answer["choice"]]].append(answer["strength"])
        ours, others = (len(told[name]) for name in ("ours", "facefx"))
        assert ours + others == paper["choices"]
        assert round(100 * (ours - others) / paper["choices"]) == printed["difference"]
        for strengths, mean in zip(told.values(), printed["strengths"], strict=True):
            assert sum(strengths) / len(strengths) == pytest.approx(mean, abs=0.01)


@full
@needs
def test_every_item_is_made_and_says_what_the_paper_says(draw_paper, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["draw_paper.py", str(tmp_path)])
    assert draw_paper.main() == 0
    listed = re.findall(r"\]\(([^)]+)\)", (tmp_path / "README.md").read_text("utf-8"))
    assert {f"figure-{number}.png" for number in (2, 3, *range(5, 11))} <= {*listed}
    for name in listed:
        made = (tmp_path / name).read_bytes()
        assert made.startswith(b"\x89PNG") if name.endswith(".png") else made, name
    for name, words in {
        "section-5.2.md": "36.75",
        "section-5.3.txt": "bareTeeth",
        "section-5.4.txt": "484 bigrams: 441 shared, 43 added by yu",
    }.items():
        assert words in (tmp_path / name).read_text("utf-8")
    report = (tmp_path / "study" / "report.txt").read_text("utf-8")
    assert all(chi in report for chi in ("44.18", "23.12", "10.58", "30.42"))
    kept = json.loads((tmp_path / "study" / "study.json").read_text("utf-8"))
    assert len(kept["pairs"]) == 40
