"""The page "How good is it?": made only from kept figures, each with its source."""

import copy
import importlib
import json
import re
import sys
from datetime import date

import pytest
from lanes import full

MODULES = (
    "articulography", "by_language", "dictionaries", "how_good", "how_good_pictures",
    "json_figures", "languages", "measure", "motion",
)  # fmt: skip
LINK = re.compile(r"\]\([^)]*\)|`[^`]*`")


@pytest.fixture
def made(root, monkeypatch):
    """Import a script of docs or benchmarks, and unload it afterwards."""
    monkeypatch.syspath_prepend(root / "docs")
    monkeypatch.syspath_prepend(root / "benchmarks")
    yield importlib.import_module
    for name in MODULES:
        sys.modules.pop(name, None)


@pytest.fixture
def how_good(made):
    return made("how_good")


@pytest.fixture
def page(how_good):
    return how_good.loaded()


# The page


def test_the_page_is_what_the_figures_make(how_good, page):
    text = how_good.PAGE.read_text("utf-8")
    assert how_good.written(text, page.block) == text, "run python docs/how_good.py"


def test_a_changed_figure_changes_the_page(how_good, page):
    text = how_good.PAGE.read_text("utf-8")
    measured = copy.deepcopy(page.measured)
    measured["articulation"]["figures"]["r"]["aperture"]["drafted bank"] = [0.123] * 3
    other = how_good.written(text, how_good.Page(measured, page.published).block)
    assert other != text
    assert other.count("0.12") > text.count("0.12")


def test_text_written_by_hand_states_no_figure(how_good):
    text = how_good.MARKED.sub("", how_good.PAGE.read_text("utf-8"))
    assert not re.findall(r"\d+", LINK.sub("", text))


def test_every_mark_is_a_part_and_every_part_has_its_mark(how_good, page):
    names = [mark[1] for mark in how_good.MARKED.findall(how_good.PAGE.read_text("utf-8"))]
    assert names
    assert len(names) == len(set(names))
    assert all(page.block(name) for name in names)
    assert {peer["part"] for peer in page.published["peers"]} <= set(names)
    assert set(page.published["unknown"]) <= set(names)


def test_fits_are_told_once_they_are_measured(how_good, page):
    without = {name: part for name, part in page.measured.items() if name != "fitting"}
    assert how_good.Page(without, page.published).block("fitting") == "Not measured yet."
    figures = {
        "posesets": {"facefx": {"aperture": {"before": [0.8, 0.9], "after": [0.7, 0.9]}}},
        "known": {"facefx": {"minutes": 10, "seconds": 42.4, "before": 0.1, "after": 0.0123}},
    }
    part = page.measured["articulation"] | {"figures": figures, "load": 7.5, "cores": 2}
    told = how_good.Page(without | {"fitting": part}, page.published)
    assert "| facefx, aperture | 0.85 | 0.80 | -0.10 to +0.00 |" in told.block("fitting")
    assert "with errors of timing and noise, in 42 s" in told.block("fitting")
    assert "0.100 before and 0.012 after" in told.block("fitting")
    assert "with a load of 7.5 on 2 cores" in told.block("fitting")
    assert told.busy(part | {"load": 0.1}) == ""
    assert "r 0.80 after a fit to the others, 0.85 before" in told.block("summary")


# Figures and their sources


def test_every_measured_part_says_how_when_and_on_what(root, page, made):
    parts = made("measure").PARTS
    assert page.measured
    for name, part in page.measured.items():
        assert (root / part["benchmark"]).is_file(), name
        assert part["command"].startswith(f"python {part['benchmark']}"), name
        assert date.fromisoformat(part["date"]), name
        assert part["inputs"], name
        assert part["figures"], name
        assert name in {*parts, "speed"}


def test_every_published_figure_has_a_source(page):
    for peer in page.published["peers"]:
        assert re.search(r"\d", peer["figure"]), peer
        assert re.search(r"\b(19|20)\d\d\b|documentation", peer["source"]), peer
        assert peer["url"].startswith("http"), peer
        assert all(peer[field] for field in ("who", "of", "data", "read", "looked_up")), peer


def test_kept_figures_name_no_machine(how_good):
    for file in (how_good.MEASURED, how_good.PUBLISHED):
        assert not re.search(r"/(work|home|Users|tmp|root)/", file.read_text("utf-8"))


def test_every_benchmark_of_the_page_writes_json(root, made):
    for name, part in made("measure").PARTS.items():
        script = root / "benchmarks" / part.benchmark
        if name == "fitting" and not script.exists():
            continue
        assert "--json" in script.read_text("utf-8") or "add_option" in script.read_text("utf-8")


# Measuring


def test_a_part_whose_data_is_missing_is_not_measured(made, tmp_path):
    measure = made("measure")
    part = measure.Part("x.py", ["DATA/here", "--flag", "two words"], "")
    assert measure.arguments_of(part, {"DATA": tmp_path}) is None
    assert measure.arguments_of(part, {"DATA": None}) is None
    (tmp_path / "here").mkdir()
    assert measure.arguments_of(part, {"DATA": tmp_path}) == [
        str(tmp_path / "here"), "--flag", "two words",
    ]  # fmt: skip
    assert measure.command_of(part) == 'python benchmarks/x.py DATA/here --flag "two words"'


def test_a_benchmark_is_run_and_its_figures_kept(made, tmp_path, monkeypatch):
    measure = made("measure")
    (tmp_path / "benchmarks").mkdir()
    script = "import sys; open(sys.argv[-1], 'w').write('{\"got\": ' + repr(len(sys.argv)) + '}')"
    (tmp_path / "benchmarks" / "tiny.py").write_text(script, encoding="utf-8")
    monkeypatch.setattr(measure, "ROOT", tmp_path)
    monkeypatch.setattr(measure, "MEASURED", tmp_path / "measured.json")
    monkeypatch.setattr(
        measure, "PARTS", {name: measure.Part("tiny.py", ["DATA"], "a grain") for name in "ab"}
    )
    (tmp_path / "measured.json").write_text('{"b": {"old": 1}}', encoding="utf-8")
    found = measure.part_of("a", {"DATA": tmp_path})
    assert found["figures"] == {"got": 4}
    assert (found["benchmark"], found["inputs"]) == ("benchmarks/tiny.py", "a grain")
    measure.save({"b": {"old": 1}, "a": found})
    kept = json.loads((tmp_path / "measured.json").read_text("utf-8"))
    assert [*kept] == ["a", "b"], "parts stand in the order of the page"


def test_a_benchmark_that_fails_leaves_its_old_figures(made, tmp_path, monkeypatch, capsys):
    measure = made("measure")
    (tmp_path / "benchmarks").mkdir()
    (tmp_path / "benchmarks" / "bad.py").write_text("raise SystemExit(3)", encoding="utf-8")
    script = "import sys; open(sys.argv[-1], 'w').write('{}')"
    (tmp_path / "benchmarks" / "good.py").write_text(script, encoding="utf-8")
    parts = {
        name: measure.Part(f"{name}.py", ["DATA"], "a grain") for name in ("bad", "good", "absent")
    }
    monkeypatch.setattr(measure, "PARTS", parts)
    monkeypatch.setattr(measure, "ROOT", tmp_path)
    monkeypatch.setattr(measure, "MEASURED", tmp_path / "measured.json")
    (tmp_path / "measured.json").write_text('{"bad": {"old": 1}}', encoding="utf-8")
    assert measure.main([str(tmp_path), "--only", *parts]) == 1
    told = capsys.readouterr()
    assert "bad fails: " in told.err
    assert "absent: its data or its benchmark is not there" in told.out
    kept = json.loads((tmp_path / "measured.json").read_text("utf-8"))
    assert [*kept] == ["bad", "good"]
    assert kept["bad"] == {"old": 1}
    assert kept["good"]["figures"] == {}


def test_speeds_are_read_from_the_page_of_the_reference(made):
    text = (
        "# Performance\n```text\ncores 2\n   figure\n\nutterance: One utterance\n"
        "40 phonemes                      67.18 us    1.034 ms     100 us           0.12 s\n"
        "\nhour: An hour\n43,373 phonemes                  38.61 ms          82 MB  0.16 s\n```\n"
    )
    found = made("measure").speeds(text, "2026-01-01")
    assert found["figures"] == {
        "utterance: 40 phonemes": "67.18 us", "hour: 43,373 phonemes": "38.61 ms",
    }  # fmt: skip
    assert found["machine"] == "cores 2"


def test_the_stated_speeds_are_those_of_the_reference(made, page, how_good):
    measure = made("measure")
    found = measure.speeds(measure.SPEEDS.read_text("utf-8"), "")["figures"]
    assert page.figures("speed") == found, "run python docs/measure.py DATA --only speed"
    assert {key for key, _ in how_good.SPEEDS} <= set(found)


def test_figures_become_plain_json(made, tmp_path):
    import numpy as np

    figures = made("json_figures")
    file = tmp_path / "f.json"
    figures.write_figures(file, {"a": np.float64(1 / 3), 12.0: (np.int64(2), True, None, "x")})
    assert json.loads(file.read_text("utf-8")) == {"a": 0.33333, "12.0": [2, True, None, "x"]}
    with pytest.raises(ValueError, match="Out of range"):
        figures.write_figures(file, {"r": float("nan")})
    assert figures.write_figures(None, {"r": object()}) is None


def test_errors_of_boundaries_are_summarised(made):
    found = made("json_figures").boundary_errors([-0.01, 0.01, 0.02, 0.2])
    assert found["boundaries"] == 4
    assert found["median_ms"] == pytest.approx(15)
    assert found["late_ms"] == pytest.approx(15)
    assert found["mean_ms"] == pytest.approx(60)
    assert (found["within_ms"]["10"], found["within_ms"]["20"]) == (0.5, 0.75)


@full
def test_two_texts_are_counted_as_the_page_reads_them(how_good, page, made, tmp_path, monkeypatch):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    texts = tmp_path / "texts"
    texts.mkdir()
    (texts / "eng.txt").write_text("Bob buys five maps.\n", encoding="utf-8")
    (texts / "fin.txt").write_text("Pappa puhuu.\n", encoding="utf-8")
    (texts / "haw.txt").write_text("No pack reads this.\n", encoding="utf-8")
    file = tmp_path / "figures.json"
    monkeypatch.setattr(sys, "argv", ["by_language.py", str(texts), "--json", str(file)])
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # the benchmark sets them
        monkeypatch.setenv(name, "1")
    with monkeypatch.context() as patch:  # and keeps to one core
        patch.setattr("os.sched_setaffinity", lambda *_: None, raising=False)
        assert made("by_language").main() == 0
    figures = json.loads(file.read_text("utf-8"))
    assert [*figures["languages"]] == ["english", "finnish"]
    assert figures["languages"]["english"]["contacts"] >= 7, "b b b f v m p"
    assert set(figures["languages"]["english"]["default"].values()) == {0}
    measured = page.measured | {"languages": page.measured["languages"] | {"figures": figures}}
    told = how_good.Page(measured, page.published)
    assert "In 2 languages, " in told.block("contacts")
    assert "| languages read | 2 |" in told.block("coverage")


def test_a_dictionary_is_judged_as_the_page_reads_it(how_good, page, made, tmp_path, monkeypatch):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    (tmp_path / "finnish.tsv").write_text(
        "pappa\t/p\u0251pp\u0251/\nmies\t/p\u0251/, /t\u0251/|/mies/\n", "utf-8"
    )
    (tmp_path / "finnish.other.tsv").write_text("pappa\t/kok\u0251/\n", encoding="utf-8")
    file = tmp_path / "figures.json"
    monkeypatch.setattr(sys, "argv", ["dictionaries.py", str(tmp_path), "--json", str(file)])
    made("dictionaries").main()
    figures = json.loads(file.read_text("utf-8"))
    right = {"error": 0, "closures": 0, "rounding": 0}
    assert figures["languages"] == {
        "finnish": {"words": 2, **right, "allowed": right},
        "finnish.other": {"words": 1, "error": 0.75, "closures": 1, "rounding": 1},
    }
    measured = page.measured | {"reading": page.measured["reading"] | {"figures": figures}}
    told = how_good.Page(measured, page.published).block("reading")
    assert (
        "The median error of 2 lists is 37.5 % of the phonemes. "
        "The worst list, finnish.other, has 75 %" in told
    )
    assert "finnish has 75 % by other, and 0 % by the other list" in told


def test_a_convention_of_a_dictionary_is_allowed_and_never_required(made):
    meant = made("dictionaries").meant
    assert meant(["ˈko ŋ.kɔ", "tako"], {"ŋ(?=k)": "n", "ɔ": "o"}) == [
        "koŋkɔ", "tako", "konkɔ", "koŋko", "konko",
    ]  # fmt: skip


def test_allowed_conventions_are_told_beside_the_errors(how_good, page):
    row = {"words": 2, "error": 0.5, "closures": 0.25, "rounding": 1}
    allowed = {"error": 0, "closures": 0.125, "rounding": 0.5}
    figures = {"languages": {"finnish": row | {"allowed": allowed}, "finnish.other": row}}
    measured = page.measured | {"reading": page.measured["reading"] | {"figures": figures}}
    told = how_good.Page(measured, page.published).block("reading")
    assert "| finnish | 2 | 50.0 % | 25.0 % | 100.0 % | 0.0 % / 12.5 % / 50.0 % |" in told
    assert "| finnish.other | 2 | 50.0 % | 25.0 % | 100.0 % |  |" in told


# Pictures


@full
def test_the_pictures_of_the_page_are_drawn(how_good, page, made, tmp_path):
    pytest.importorskip("matplotlib", reason="the plot extra is not installed")
    made("how_good_pictures").draw(page, tmp_path)
    wanted = set(re.findall(r"\(\.\./images/(how-good-\w+\.png)\)", how_good.PAGE.read_text()))
    assert {path.name for path in tmp_path.iterdir()} == wanted
    for name in wanted:
        assert (how_good.DOCS / "images" / name).is_file(), "run python docs/how_good.py"
