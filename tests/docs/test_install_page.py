"""The page on installation: every extra is in its table, with the kept sizes."""

import json
import runpy

import pytest
from places import ROOT

MAKER = runpy.run_path(str(ROOT / "docs/measure_extras.py"), run_name="measure_extras")
PAGE = (ROOT / "docs/how-to/install.md").read_text(encoding="utf-8")
KEPT = json.loads((ROOT / "docs/extras_mb.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", MAKER["names"]())
def test_every_extra_is_in_the_table(name):
    assert PAGE.count(f"\n| `{name}` | ") == 1


def test_the_table_is_made_from_the_kept_sizes():
    assert MAKER["written"](PAGE, KEPT) == PAGE
    assert set(KEPT["beyond_core_mb"]) <= set(MAKER["names"]())


def test_a_size_that_nobody_measured_is_named():
    told = MAKER["table"]({**KEPT, "beyond_core_mb": {}})
    assert told.count("| not measured |") == len(MAKER["names"]())
