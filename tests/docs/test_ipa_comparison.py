"""The table of differences between languages in the reference: each has a reason."""

import importlib

import pytest
from packs_tree import put
from shipped import LIBRARY

from lipsync_lang.packs.library import Library


@pytest.fixture
def compared(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "docs")
    return importlib.import_module("ipa_comparison")


def unexplained(row):
    """Return the names of the packs that differ without a reason."""
    return [name for one in row.unusual if not one.reason for name in one.languages]


def test_no_symbol_is_mapped_differently_by_two_packs_without_a_reason(compared):
    rows = compared.compare(LIBRARY)
    assert {row.symbol: unexplained(row) for row in rows if unexplained(row)} == {}
    assert next(row for row in rows if row.symbol == "ŋ").usual == ("ng",)


def test_packs_differ_by_a_reason_a_shared_decision_or_their_letters(compared, tmp_path):
    head = "kind: language\nformat: 1\ntag: qaa\n"
    table = "notations: {ipa: {e: eh, eː: eh, l: l, el: [eh, l], x: kg, q: kg, ɸ: f}}\n"
    other = "notations: {ipa: {e: ah, eː: ah, l: l, el: [ah, l], x: h, q: h, ɸ: bw}}\n"
    for name, text in (("one", table), ("two", table), ("odd", f"{other}reasons: {{e: weak}}\n")):
        put(tmp_path, f"languages/{name}.yaml", f"{head}name: {name}\n{text}")
    library = Library([tmp_path], project=None)
    decided = [one for one in library.ipa().model.decided if "x" in one.labels]
    packs = [library.language(name).model for name in ("one", "two", "odd")]
    rows = {row.symbol: row for row in compared.compare_models(packs, decided)}
    why = {symbol: one.reason for symbol, row in rows.items() for one in row.unusual}
    assert why == {
        "e": "weak",
        "eː": "as e",
        "el": "as e and l",
        "x": decided[0].why,
        "q": "",
        "ɸ": "",
    }
    assert [symbol for symbol, row in rows.items() if unexplained(row) == ["odd"]] == ["q", "ɸ"]
    assert rows["e"].languages == ("one", "two")
