"""A file of each kind of script, alone in a folder, to files of its lines."""

import pytest
from script_samples import SEEDS

ALONE = sorted(
    path
    for kind in SEEDS.iterdir()
    if kind.name not in {"schedule", "subtitles", "table", "text", "xlsx"}
    for path in kind.iterdir()
)


@pytest.mark.full
@pytest.mark.parametrize("seed", ALONE, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_a_script_alone_becomes_a_project_whose_lines_talk(seed, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / seed.name).write_bytes(seed.read_bytes())
    made = cli("new", "--from", seed.name)
    assert made.code == 0, made.err
    built = cli("build")
    assert built.code == 0, built.err
    takes = list((tmp_path / "takes").rglob("*.csv"))
    assert f"\n{len(takes)} line" in made.err
    assert all(one.read_text("utf-8").count("\n") > 10 for one in takes)
