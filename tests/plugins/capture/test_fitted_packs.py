"""Packs from a fit: targets and times of a character, and fitted bigrams."""

import json
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from packs_tree import put
from shipped import LIBRARY

import lipsync_lang
from lipsync_lang import LipsyncError, PackError, Schedule, resolve
from lipsync_lang.packs.banks.write import write_drafts
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.describe import show
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import BigramCurves
from lipsync_lang.reports.coverage import page
from lipsync_lang.reports.coverage.matrix import coverage
from lipsync_lang.reports.coverage.report import authored
from lipsync_lang.reports.quality.baselines import dominance
from lipsync_lang.resolver.bank_diff import diff_banks
from lipsync_lang.resolver.bigram_sources import draft_bigrams
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.studio.routes import character_routes, coverage_routes, language_routes
from lipsync_lang.studio.routes.requests import StudioRequest
from lipsync_lang.studio.workshop import Workshop
from lipsync_lang.text.lines.line_readers import read_lines

PACKAGE = Path(lipsync_lang.__file__).parent

HEAD = "kind: character\nformat: 1\nname: anna\nposeset: facefx\n"
CURVES = "curves: {{open: [[0, 0], [0.5, {height}], [1, 0]]}}"
LINE = Schedule(("m", "uː", "l", "oʊ", "m"), np.array([0.1, 0.2, 0.4, 0.5, 0.7, 0.8]))


def anna(folder, text):
    put(folder, "characters/anna.yaml", HEAD + text)


def bank(folder, name, bigrams, language="null"):
    head = f"kind: bank\nformat: 1\nname: {name}\nposeset: facefx\nlanguage: {language}\nbigrams:\n"
    put(folder, f"posesets/facefx/banks/{name}.yaml", head + bigrams)


def entry(key, status, height):
    return f"  {key}: {{status: {status}, {CURVES.format(height=height)}}}\n"


def made(folder, character="anna"):
    return compile_pair(Library([folder], project=None), "english", character)


def origin(made, pair):
    return next(one for one in made.origins if one.pair == pair)


def faults(folder):
    return [str(fault) for fault in validate(Library([folder], project=None))]


# A character's own targets and seconds


def test_a_character_drafts_from_its_own_targets(tmp_path):
    anna(tmp_path, "targets: {ow: {open: 0.9, W: 0.1, status: fitted}}\n")
    own, bare = made(tmp_path), made(tmp_path, "facefx")
    pose, row = own.poses.index("open"), own.phonemes.index("ow")
    low = own.phonemes.index("l")
    height = [
        float(one.tables.curves[one.tables.pairs[low, row], :, pose].max()) for one in (own, bare)
    ]
    assert height[0] > height[1] + 0.2
    assert any("anna.yaml:5:" in place for place in origin(own, ("l", "ow")).places)
    assert origin(own, ("l", "aa")) == origin(bare, ("l", "aa"))


def test_targets_of_a_character_count_for_room_and_opposition(tmp_path):
    anna(tmp_path, "targets: {l: {open: 1.0, W: 0}}\n")
    own, bare = made(tmp_path), made(tmp_path, "facefx")
    number, opened, rounded = own.phonemes.index("l"), *map(own.poses.index, ("open", "W"))
    assert own.tables.highest[opened] == 1
    assert own.tables.highest[opened] > bare.tables.highest[opened]
    assert own.tables.opposed[number, rounded]
    assert not bare.tables.opposed[number, rounded]


def test_the_baseline_blends_a_characters_own_targets(tmp_path):
    anna(tmp_path, "targets: {ow: {open: 0.9}}\n")
    library = Library([tmp_path], project=None)
    peaks = [
        dominance(resolve("english", name, paths=[tmp_path]), LINE, 60, library).weights.max(axis=0)
        for name in ("anna", "facefx")
    ]
    assert peaks[0].max() > 0.8
    assert not np.allclose(*peaks)


def test_a_character_has_softness_and_anticipation_of_its_own(tmp_path):
    anna(tmp_path, "softness: {jaw: 0.1, lips: 0.2}\nanticipate: {W: 0.3}\n")
    own, bare = made(tmp_path), made(tmp_path, "facefx")
    model = LIBRARY.poseset("facefx").model
    for number, (name, pose) in enumerate(model.poses.items()):
        stated = {"jaw": 0.1, "lips": 0.2}.get(pose.region)
        soft = bare.tables.softness[number] if stated is None else stated
        assert own.tables.softness[number] == (soft if pose.softness is None else pose.softness)
        early = 0.3 if name == "W" else bare.tables.anticipate[number]
        assert own.tables.anticipate[number] == early


def test_a_change_of_the_character_is_seen_through_the_cache(tmp_path):
    anna(tmp_path, "anticipate: {W: 0.3}\n")
    first = resolve("english", "anna", paths=[tmp_path]).perform(LINE)
    anna(tmp_path, "anticipate: {W: 0.0}\ntargets: {ow: {W: 1.0}}\n")
    second = resolve("english", "anna", paths=[tmp_path]).perform(LINE)
    assert not np.array_equal(first.weights, second.weights)


FAULTY = {
    "targets: {oww: {open: 0.5}}": "5:11: P202 unknown phoneme 'oww'",
    "targets: {ow: {opne: 0.5}}": "P201 unknown pose 'opne'\n  hint: did you mean 'open'",
    "targets: {ow: {dominance: {opne: 2}}}": "P201 unknown pose 'opne'",
    "targets: {ow: {open: 0.5, status: fited}}": "must be fitted",
    "targets: {ow: {open: 1.5}}": "P104 `open` must be at most 1",
    "targets: {bmp: {PBM: 0.2, open: 0}}": "5:11: W314 warning: 'PBM' gets to 0.2, but contact",
    "softness: {jaws: 0.05}": "5:12: P230 unknown region 'jaws'\n  hint: did you mean 'jaw'",
    "softness: {jaw: 5}": "P104 `jaw` must be at most 0.2",
    "anticipate: {w: 0.1}": "P201 unknown pose 'w'\n  hint: did you mean 'W'",
    "anticipate: {W: 10}": "P104 `W` must be at most 1",
    "fitted: {jaw: 0.1}": "P106 'jaw' is not a value of a fit",
    "fitted: {softness.jaw: 0.1}": "5:10: W308 warning: the character states no `softness.jaw`",
}


@pytest.mark.parametrize("text", sorted(FAULTY))
def test_a_faulty_value_is_named_with_its_place_and_cure(text, tmp_path):
    anna(tmp_path, text + "\n")
    (told,) = faults(tmp_path)
    assert "anna.yaml" in told
    assert FAULTY[text] in told


def test_a_character_with_all_fields_is_sound(tmp_path):
    anna(
        tmp_path,
        "targets: {ow: [{open: 0.4, dominance: 2, status: fitted}, {W: 0.9}]}\n"
        "softness: {jaw: 0.05}\nanticipate: {W: 0.1}\nmotion: {speed_limit: 12}\n"
        "fitted: {softness.jaw: 0.05, anticipate.W: 0.1, motion.speed_limit: 12}\n"
        "bigrams: {l-ow: {status: fitted, curves: {open: [[0, 0], [1, 0.5]]}}}\n",
    )
    assert faults(tmp_path) == []
    model = Library([tmp_path], project=None).character("anna").model
    assert [model.scalar(item) for item in model.fitted] == [0.05, 0.1, 12]
    (first, second) = model.targets["ow"]
    assert (first.overall, first.status, second.status) == (2, "fitted", None)


def test_drafts_of_own_targets_are_not_put_into_the_bank_of_every_face(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    anna(tmp_path, "targets: {ow: {open: 0.9}}\n")
    drafts = draft_bigrams(Library(), "english", "anna", ["l-ow"])
    with pytest.raises(LipsyncError, match=r"'anna' has its own targets.*--to characters"):
        write_drafts(Library(), drafts)
    assert not (tmp_path / "posesets").exists()
    own = tmp_path / "characters/anna-bank.yaml"
    told = write_drafts(Library(), drafts, own)
    assert told.startswith("1 drafted bigram put into")
    assert told.endswith("state `banks: [anna-bank.yaml]` in " + str(Path("characters/anna.yaml")))
    assert not draft_bigrams(Library(), "english", "facefx", ["l-ow"]).character


def test_a_description_of_a_character_tells_its_own_values(tmp_path):
    anna(tmp_path, "targets: {ow: {open: 0.9}}\nsoftness: {jaw: 0.05}\nanticipate: {W: 0.1}\n")
    told = show(Library([tmp_path], project=None), "character", "anna").text.splitlines()
    assert {"targets of its own: ow", "softness: jaw 0.05", "anticipate: W 0.1"} <= set(told)


def test_the_studio_shows_the_mouth_of_a_characters_own_target(tmp_path):
    anna(tmp_path, "targets: {ow: {open: 0.9}}\n")
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("english", "anna")
    told = language_routes.mouth(workshop, StudioRequest(name="ow"))
    (step,) = told["steps"]
    assert max(step) == pytest.approx(0.9)


def test_the_studio_tells_which_targets_the_character_replaces(tmp_path):
    anna(tmp_path, "targets: {ow: {open: 0.9}}\n")
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("english", "anna")
    told = character_routes.character(workshop, StudioRequest())
    assert [one["name"] for one in told["phonemes"] if one["replaced"]] == ["ow"]
    assert told["stated"]["targets"]["ow"] != {"open": 0.9}


# Fitted bigrams


def test_a_fitted_bigram_comes_before_a_draft(tmp_path):
    anna(tmp_path, "bigrams:\n" + entry("l-ow", "fitted", 0.9))
    found = origin(made(tmp_path), ("l", "ow"))
    assert (found.layer, found.status) == ("character", "fitted")
    assert made(tmp_path).report.layers["character"] == {"fitted": 1}
    assert not authored(found.layer, found.status)


@pytest.mark.parametrize("status", ["approved", "edited"])
def test_a_bigram_of_a_person_in_any_layer_comes_before_a_fitted_one(status, tmp_path):
    bigrams = "".join(entry(key, "fitted", 0.9) for key in ("l-ow", "d-ow", "m-ow"))
    anna(tmp_path, "banks: [own.yaml]\nbigrams:\n" + bigrams.replace("m-ow", "bmp-ow"))
    head = "kind: bank\nformat: 1\nname: own\nposeset: facefx\nbigrams:\n"
    put(tmp_path, "characters/own.yaml", head + entry("l-ow", status, 0.2))
    bank(tmp_path, "spoken", entry("d-ow", status, 0.2), "english")
    bank(tmp_path, "shared", entry("bmp-ow", status, 0.2))
    found = made(tmp_path)
    stands = [origin(found, (one, "ow")) for one in ("l", "d", "bmp")]
    assert [(one.layer, one.status) for one in stands] == [
        ("character", status), ("language", status), ("shared", status),
    ]  # fmt: skip


def test_a_fitted_bigram_comes_before_a_draft_that_was_put_into_a_bank(tmp_path):
    anna(tmp_path, "bigrams:\n" + entry("l-ow", "drafted", 0.2) + entry("d-ow", "drafted", 0.2))
    bank(tmp_path, "shared", entry("l-ow", "fitted", 0.9))
    found = made(tmp_path)
    assert origin(found, ("l", "ow")).status == "fitted"
    assert origin(found, ("d", "ow")).status == "drafted"


def test_a_drawn_parent_comes_before_a_fitted_shade(tmp_path):
    shade = next(name for name, one in LIBRARY.common().model.shades.items() if one.like == "ah")
    anna(tmp_path, "bigrams:\n" + entry(f"l-{shade}", "fitted", 0.9) + entry("l-ah", "edited", 0.2))
    found = made(tmp_path)
    first, finer, coarse = map(found.phonemes.index, ("l", shade, "ah"))
    curves = [found.tables.curves[found.tables.pairs[first, one]] for one in (finer, coarse)]
    assert np.array_equal(*curves)
    assert origin(found, ("l", shade)).status == "edited"
    anna(tmp_path, "bigrams:\n" + entry(f"l-{shade}", "fitted", 0.9))
    assert origin(made(tmp_path), ("l", shade)).status == "fitted"


def test_a_comparison_of_banks_tells_fitted_bigrams(tmp_path):
    anna(tmp_path, "bigrams:\n" + entry("l-ow", "fitted", 0.9))
    (change,) = diff_banks(Library([tmp_path], project=None), "english", "anna", None, ()).changes
    assert (change.bigram, str(change.after)) == ("l-ow", "character, fitted")


def test_a_status_that_is_unknown_is_refused(tmp_path):
    anna(tmp_path, "bigrams: {l-ow: {status: guessed, curves: {}}}\n")
    with pytest.raises(PackError, match="one of drafted, fitted, edited, approved"):
        made(tmp_path)


STATUSES = get_args(BigramCurves.model_fields["status"].annotation)
STUDIO, PAGE = PACKAGE / "studio/static", PACKAGE / "base/presentation/templates"


@pytest.mark.parametrize("status", sorted(STATUSES))
def test_every_status_has_a_colour_and_words_wherever_statuses_are_shown(status):
    code = page.STATE_CODES[list(page.STATUSES).index(status)]
    assert f".s{code} {{ --c: var(--{status}) }}" in (PAGE / "style.css").read_text("utf-8")
    curves = (STUDIO / "curves/curves.css").read_text("utf-8")
    assert curves.count(f"--status-{status}: #") == 2, "by day and by night"
    assert f":is(.matrix, .matrix-legend) .{status} {{" in curves
    view = (STUDIO / "views/bigram_view.js").read_text("utf-8")
    undrawn = re.search(r"const UNDRAWN = (\[.*\]);", view)[1]
    assert (status in json.loads(undrawn)) is not authored("shared", status)
    assert f".shares .{status}," in (STUDIO / "views/coverage_view.css").read_text("utf-8")
    for script in ("views/bigram_matrix.js", "views/coverage_view.js"):
        assert re.search(rf"\b{status}: ", (STUDIO / script).read_text("utf-8")), script


def test_the_studio_tells_fitted_bigrams_from_drafts(tmp_path):
    put(tmp_path, "script.txt", "low\n")
    anna(tmp_path, "bigrams:\n" + entry("l-ow", "fitted", 0.9))
    lines = read_lines(tmp_path / "script.txt")
    report = coverage(lines, "english", "anna", paths=[tmp_path])
    told = coverage_routes._report_data(report.reports[0])  # noqa: SLF001 the view of a count that is done
    assert told["status"]["fitted"] == [1, 1]
    assert "l-ow" in [need["bigram"] for need in told["plan"]]
    assert report.reports[0].left.bigrams == len(told["plan"])


def test_an_edit_in_the_studio_keeps_what_a_fit_wrote(tmp_path):
    text = (
        "targets: {ow: [{open: 0.4, status: fitted}, {W: 0.9}]}   # from captures\n"
        "softness: {jaw: 0.05}\nanticipate: {W: 0.1}\n"
        "fitted: {softness.jaw: 0.05, anticipate.W: 0.1}\n"
        "bigrams:\n" + entry("l-ow", "fitted", 0.9)
    )
    anna(tmp_path, text)
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("english", "anna")
    path = tmp_path / "characters/anna.yaml"
    drawn = {"status": "edited", "curves": {"open": [[0, 0], [1, 1]]}}
    workshop.edit("Draw", [(path, ("bigrams", "d-ow"), drawn)])
    workshop.edit("Draw", [(path, ("bigrams", "l-ow", "status"), "edited")])
    edited = workshop.desk.contents[path].decode()
    kept, _, bigrams = edited.partition("bigrams:\n")
    assert kept == HEAD + text.partition("bigrams:\n")[0]
    assert "status: fitted" not in bigrams
    compiled = workshop.performer.compiled
    assert origin(compiled, ("l", "ow")).status == "edited"
    assert compiled.tables.softness[compiled.poses.index("open")] == 0.05
    other = tmp_path / "other"
    put(other, "characters/anna.yaml", edited)
    fresh = made(other)
    assert np.array_equal(compiled.tables.curves, fresh.tables.curves)
