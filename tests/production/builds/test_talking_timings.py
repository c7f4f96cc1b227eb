"""The timings of each service and program, alone in a folder, to a line that talks."""

import pytest
from lanes import swept
from places import TESTS

from lipsync_lang.schedules.timing_readers import TIMING_READERS

EXAMPLES = sorted(TESTS.glob("**/examples/*.*"), key=lambda path: path.name)
"""A file of each format, named after it, with the same line."""


@pytest.mark.parametrize("example", swept(EXAMPLES), ids=lambda path: path.stem)
def test_timings_alone_become_a_project_whose_line_talks(example, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script = f"line{TIMING_READERS[example.stem].suffixes[0]}"
    (tmp_path / script).write_bytes(example.read_bytes())
    made = cli("new", "--from", script)
    assert made.code == 0, made.err
    built = cli("build")
    assert built.code == 0, built.err
    run = cli("run", "--schedule", script, "-l", "english", "-c", "facefx", "-o", "run.csv")
    assert run.code == 0, run.err
    takes = [*(tmp_path / "takes").rglob("*.csv"), tmp_path / "run.csv"]
    assert len(takes) == 2
    for take in takes:
        head, *rows = take.read_text("utf-8").splitlines()
        assert len(rows) > 30
        moves = [set(column) for column in zip(*(row.split(",")[1:] for row in rows), strict=True)]
        assert sum(len(values) > 10 for values in moves) > 2, head
