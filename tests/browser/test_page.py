"""The coverage page in a browser: sorting, filtering and no other requests."""

import json
from pathlib import Path

import pytest
from lanes import full, swept
from test_consumers import chromium, found, run
from test_coverage_page import EMPTY, NASTY, made, spoiled

from lipsync_lang.reports.coverage.page import page

HERE = Path(__file__).parent
REPORT, SOUGHT = 3, "bmp"


@pytest.fixture
def show(tmp_path):
    """Use the page of a document in a browser, and return the results."""

    def show(document):
        node, modules = found("playwright-core")
        path = tmp_path / "coverage.html"
        path.write_text(page(document), "utf-8")
        shown = run(node, HERE / "show.mjs", modules, chromium(), path, str(REPORT), SOUGHT)
        assert (shown["said"], shown["asked"]) == ([], [])
        assert shown["overflow"] <= 0
        return shown

    return show


def ranking(rows):
    """Return the texts of the first seven columns."""
    return [
        [
            str(rank), row["bigram"], f"{row['count']:,}", f"{row['percent']:.2f}",
            f"{row['running']:.2f}", row["status"] or "gap", row["layer"],
        ]
        for rank, row in enumerate(rows, 1)
    ]  # fmt: skip


@full
def test_a_reader_can_choose_search_filter_and_sort(show):
    document = made(2, 2)
    first, chosen = document["reports"][0], document["reports"][REPORT]
    shown = show(document)
    assert shown["title"] == "English on facefx"
    assert [cells[:7] for cells in shown["ranked"]] == ranking(first["bigrams"])
    for part, rows in (("ranked", chosen["bigrams"]), ("silence", chosen["silence"])):
        assert [cells[:7] for cells in shown["chosen"][part]] == ranking(rows)
    assert shown["chosen"]["title"] == shown["linked"] == shown["entered"] == "Spanish on mira"
    assert shown["again"], "what was there comes back as it was"
    names = [row["bigram"] for row in first["bigrams"]]
    assert shown["sought"] == [name for name in names if SOUGHT in name]
    statuses = [row["status"] or "gap" for row in first["bigrams"]]
    assert shown["filtered"] == [one for one in statuses if one != "approved"]
    assert shown["sorted"] == sorted(names)


@full
def test_the_map_can_be_walked_by_keyboard(show):
    shown = show(made(2, 2))
    before, after = (tip.split("-") for tip in shown["tips"])
    assert before[1] == after[1]
    assert before[0] != after[0]
    assert shown["hushed"]


@full
def test_paper_has_every_row_and_no_controls(show):
    shown = show(made(2, 2))
    assert (shown["printed"], shown["cut"]) == ([], 0)


@full
def test_without_scripts_the_first_report_can_be_read(show):
    document = made(2, 2)
    still = show(document)["still"]
    assert still["controls"] == 0
    assert "English on facefx" in still["text"]
    missing = [
        r["bigram"] for r in document["reports"][0]["bigrams"] if r["bigram"] not in still["text"]
    ]
    assert not missing


@full
def test_no_text_of_a_corpus_runs(show):
    shown = show(spoiled(made(2, 2), "".join(NASTY)))
    assert shown["chosen"]["title"].startswith("Spanish")


@full
@pytest.mark.parametrize("document", swept(EMPTY.values()), ids=EMPTY)
def test_a_page_of_nothing_opens(document, show):
    one = document["reports"]
    many = json.loads(json.dumps(document | {"reports": one * (REPORT + 1)}))
    show(many)
