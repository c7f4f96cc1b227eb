"""Fits to captures: known faces are found again, and overfitted values are refused."""

import io
import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from captures import FPS, captured, changed_face, open_pair, random_lines, rms
from lanes import full, swept
from shipped import POSESETS

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.cli import main
from lipsync_lang.packs.library import Library
from lipsync_lang.performing.performer import Performer
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.plugins.capture.accept_fit import accept_fit
from lipsync_lang.plugins.capture.capture_reading import read_captures
from lipsync_lang.plugins.capture.fit_captures import (
    _remarks,
    confidence,
    fit_captures,
    without_rest,
)
from lipsync_lang.plugins.capture.fit_file import read_fit, write_fit
from lipsync_lang.plugins.capture.fit_folds import folds
from lipsync_lang.plugins.capture.fit_lines import fit_rate, lay_lines
from lipsync_lang.plugins.capture.fit_steps import (
    TargetParameters,
    control_slopes,
    draft_slopes,
    seen_poses,
    solve,
)
from lipsync_lang.plugins.capture.fit_values import FitFace
from lipsync_lang.resolver.retouch import OpenPair

LINES = 8
"""Lines of a fit: each sound occurs some 8 times."""


@cache
def example(character="facefx", lines=LINES, jitter=0.01, sounds=38):
    """Return a pair, its performer, the true face, its lines, and their captures."""
    random = np.random.default_rng(0)
    pair, performer = open_pair(character=character)
    said = random_lines(random, lines, sounds)
    truth = changed_face(pair, performer, random, said)
    return pair, performer, truth, said, captured(truth, said, random, jitter=jitter, noise=0.02)


@cache
def fitted(character):
    """Return the fit to the captures of `example`, which tests share."""
    pair, performer, _, _, lines = example(character)
    return fit_captures(pair, performer, lines)


def clean_error(fit, performer, truth, said):
    """Return the error of the fitted curves on timings without errors."""
    lines = lay_lines(performer, captured(truth, said), FPS)
    return rms(fit.face.errors(fit.face.start, lines)), rms(fit.face.errors(fit.values, lines))


@pytest.mark.parametrize("character", swept(sorted(POSESETS), ["facefx"]))
def test_a_known_face_is_found_again(character):
    pair, performer, truth, said, _ = example(character)
    if pair.compiled.motion.hold:
        pytest.skip(f"{character} shows one drawing at a time, which no weight can be read from")
    fit = fitted(character)
    before, after = clean_error(fit, performer, truth, said)
    assert after < 0.03, "the goal with 20 occurrences and errors of 10 ms"
    assert after < before / 2
    assert fit.proposal.verdict.accepted
    optional = pair.shelf.poseset.model.optional_poses.keys()
    for item in (one for one in fit.proposal.items if one.kind == "targets"):
        for was, now in zip(item.was, item.value, strict=True):
            kept = optional & was.keys()
            assert [now[pose] for pose in kept] == [was[pose] for pose in kept], item.item


def how_far(item):
    """Return the largest change of a pose in an item of targets."""
    steps = zip(item.was, item.value, strict=True)
    return max(abs(now[p] - was[p]) for was, now in steps for p in was.keys() - {"dominance"})


def test_items_tell_occurrences_errors_and_confidence():
    said, proposal = example("facefx")[3], fitted("facefx").proposal
    items = {item.item: item for item in proposal.items}
    spoken = sum(list(one.labels).count("M") + list(one.labels).count("P") for one in said)
    spoken += sum(list(one.labels).count("B") for one in said)
    assert items["targets.bmp"].occurrences == spoken
    fell = [one.residual_after < one.residual_before for one in items.values()]
    assert np.mean(fell) > 0.9
    targets = [one for one in items.values() if one.kind == "targets"]
    assert len(targets) > 20
    # a target that stays where it was says nothing of its errors
    assert min(one.confidence for one in targets if how_far(one) > 0.02) > 0.5
    assert proposal.lines == LINES
    assert all(fold.after < fold.before for fold in proposal.verdict.folds)


def test_targets_gain_the_poses_that_captures_show():
    pair, performer, _, said, _ = example(lines=4)
    lines = lay_lines(performer, captured(performer, said), FPS)
    face = FitFace.of(pair, lines)
    name, pose = face.names.index("s"), performer.poses.index("FV")
    assert not face.start.mentioned[name, pose]
    weights, dominance = face.start.weights.copy(), face.start.dominance.copy()
    weights[name, 0, pose], dominance[name, pose] = 0.5, 0.0
    truth = replace(face.start, weights=weights, dominance=dominance)
    tables = replace(pair.compiled, tables=face.tables_with(truth))
    fit = fit_captures(pair, performer, captured(Performer(tables, performer.motion), said))
    (item,) = [one for one in fit.proposal.items if one.item == "targets.s"]
    (step,) = item.value
    assert step["FV"] == pytest.approx(0.5, abs=0.08)
    assert "FV" not in item.was[0]


ANNA = """kind: character
format: 1
name: anna
poseset: facefx
rig: facefx-to-arkit
"""


@pytest.fixture
def anna(tmp_path, monkeypatch):
    """A character of the project in this folder, whose rig has bounds."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    (tmp_path / "characters" / "anna.yaml").write_text(ANNA, "utf-8")
    return tmp_path


@full
def test_channels_of_a_rig_are_followed_within_its_bounds(anna):
    pair = OpenPair.open(Library(), "english", "anna")
    performer = Performer(pair.compiled, pair.compiled.motion)
    random = np.random.default_rng(0)
    said = random_lines(random, 3)
    truth = changed_face(pair, performer, random, said)
    lines = []
    for line, schedule in zip(captured(truth, said), said, strict=True):
        shown = truth.rigged(truth.perform(schedule, FPS))
        shown.save(anna / f"{line.name}.csv")
        schedule.save(anna / f"{line.name}.TextGrid")
    lines = read_captures(performer, anna).lines
    assert all(line.rigged for line in lines)
    fit = fit_captures(pair, performer, lines)
    before, after = (
        np.mean([getattr(fold, side) for fold in fit.proposal.verdict.folds])
        for side in ("before", "after")
    )
    assert after < 0.02 < before


@pytest.mark.usefixtures("anna")
def test_accepted_items_perform_what_the_fit_showed():
    pair = OpenPair.open(Library(), "english", "anna")
    performer = Performer(pair.compiled, pair.compiled.motion)
    random = np.random.default_rng(0)
    said = random_lines(random, 2)
    truth = changed_face(pair, performer, random, said)
    values = captured(truth, said)
    fit = fit_captures(pair, performer, values)
    done = accept_fit(Library(), fit.proposal, "anna", every=True, confidence=0)
    assert len(done.taken) == len(fit.proposal.items) > 20
    accepted = resolve("english", "anna", cache=False)
    errors = [
        accepted.perform(schedule, FPS).weights - truth.perform(schedule, FPS).weights
        for schedule in said
    ]
    shown = fit.face.errors(fit.values, lay_lines(performer, values, FPS))
    assert rms(np.concatenate([one.ravel() for one in errors])) == pytest.approx(
        rms(shown), abs=0.01
    )


@full
def test_fits_in_one_process_and_in_two_are_the_same():
    pair, performer, _, _, lines = example(lines=4)
    texts = []
    for workers in (1, 2):
        text = io.StringIO()
        write_fit(text, fit_captures(pair, performer, lines, workers=workers).proposal)
        texts.append(text.getvalue())
    assert texts[0] == texts[1]


@full
def test_what_does_not_generalise_is_refused_with_the_numbers():
    pair, performer, _, said, _ = example(lines=6)
    lines = captured(performer, said)
    others = [replace(line, schedule=said[at - 1]) for at, line in enumerate(lines)]
    random = np.random.default_rng(1)
    wild = [
        replace(one, values=np.clip(one.values * random.uniform(0.2, 2, one.values.shape[1]), 0, 1))
        for one in others
    ]
    verdict = fit_captures(pair, performer, wild).proposal.verdict
    before, after = (
        np.mean([getattr(one, side) for one in verdict.folds]) for side in ("before", "after")
    )
    assert verdict.accepted == (after < before)
    assert f"{before:.3f}"[:4] in verdict.why
    if not verdict.accepted:
        assert "does not generalise" in verdict.why


def test_a_face_that_is_right_already_stays_as_it_is():
    pair, performer, _, said, _ = example(lines=2)
    fit = fit_captures(pair, performer, captured(performer, said))
    assert not fit.proposal.verdict.accepted or not fit.proposal.items
    assert rms(fit.values.weights - fit.face.start.weights) < 0.003


def test_one_line_alone_is_refused():
    pair, performer, _, _, lines = example(lines=4)
    verdict = fit_captures(pair, performer, lines[:1]).proposal.verdict
    assert not verdict.accepted
    assert "add lines" in verdict.why


@full
def test_a_line_of_other_timings_is_set_aside_by_name():
    pair, performer, _, said, lines = example()
    wrong = replace(lines[3], schedule=said[4])
    fit = fit_captures(pair, performer, [*lines[:3], wrong, *lines[4:]])
    (aside,) = fit.proposal.set_aside
    assert aside.line == wrong.name
    assert "timings" in aside.why
    assert fit.proposal.lines == LINES - 1


@full
def test_scale_and_offset_of_free_signals_do_not_matter():
    pair, performer, _, _, lines = example(lines=4)
    free = [replace(line, free=True) for line in lines]
    other = [replace(line, values=line.values * 7.5 - 3) for line in free]
    texts = []
    for some in (free, other):
        text = io.StringIO()
        write_fit(text, fit_captures(pair, performer, some).proposal)
        texts.append(text.getvalue())
    assert texts[0] == texts[1]


@full
def test_levels_at_rest_are_taken_away_and_told():
    pair, performer, truth, said, _ = example(lines=2)
    lines = captured(truth, said)
    jaw = lines[0].signals.index("open")
    raised = np.zeros(len(lines[0].signals))
    raised[jaw] = 0.12
    high = [replace(line, values=line.values + raised) for line in lines]
    fits = [fit_captures(pair, performer, some) for some in (lines, high)]
    assert rms(fits[0].values.weights - fits[1].values.weights) < 0.01
    (told,) = [one for one in fits[1].proposal.remarks if "at rest" in one]
    assert told == "weights at rest were subtracted (open 0.12)"
    free = [replace(line, free=True) for line in high]
    assert without_rest(performer, free) == free


@full
def test_a_remark_on_many_files_is_told_once():
    *_, lines = example()
    both = [("a.csv: 60 frames", "anna has no width"), ("b.csv: 60 frames", "anna has no width")]
    told = [replace(line, remarks=own) for line, own in zip(lines, both, strict=False)]
    alone = replace(lines[0], remarks=("c.csv: 30 frames",))
    assert [*_remarks([*told, alone])] == [
        "a.csv and 1 more: 60 frames", "anna has no width", "c.csv: 30 frames",
    ]  # fmt: skip


def test_lost_values_and_missing_signals_do_not_count():
    pair, performer, truth, said, lines = example()
    poses = list(performer.poses)
    jaw = poses.index("open")
    others = [n for n in range(len(poses)) if n != jaw]
    lost = []
    for line in lines:
        values = line.values[:, others].copy()
        values[10:20] = np.nan
        signals = tuple(poses[n] for n in others)
        lost.append(replace(line, values=values, signals=signals, gains=line.gains[others]))
    fit = fit_captures(pair, performer, lost)
    assert rms(fit.values.weights[..., jaw] - fit.face.start.weights[..., jaw]) == 0
    before, after = clean_error(fit, performer, truth, said)
    assert after < before


def test_nothing_to_fit_to_says_why():
    pair, performer, _, _, lines = example(lines=4)
    with pytest.raises(LipsyncError, match="no capture can be used"):
        fit_captures(pair, performer, [])
    empty = [replace(line, values=np.full_like(line.values, np.nan)) for line in lines]
    with pytest.raises(LipsyncError, match="have no motion during the speech"):
        fit_captures(pair, performer, empty)


def test_folds_leave_out_lines_and_speakers():
    _, performer, _, said, _ = example(lines=6)
    lines = [
        *captured(performer, said[:3], speaker="ann"),
        *captured(performer, said[3:], speaker="bo"),
    ]
    lines = [replace(line, name=f"{line.speaker}/{line.name}") for line in lines]
    parts = folds(lay_lines(performer, lines, FPS))
    assert {part.by for part in parts} == {"line", "speaker"}
    for part in parts:
        assert not set(part.kept) & set(part.tested)
        assert len(part.kept) + len(part.tested) == 6
    assert [part.name for part in parts if part.by == "speaker"] == ["ann", "bo"]
    many = [replace(line, name=f"{line.name}/{n}") for n in range(5) for line in lines]
    names = [part.name for part in folds(lay_lines(performer, many, FPS)) if part.by == "line"]
    assert names[0].endswith(" and 2 more")


def test_slopes_are_those_of_the_pipeline():
    pair, performer, _, _, lines = example(lines=4)
    laid = lay_lines(performer, lines, FPS)
    face = FitFace.of(pair, laid)
    parameters = TargetParameters.of(face, face.start, seen_poses(laid))
    slopes = control_slopes(face, face.start, laid) @ draft_slopes(face, face.start)
    slopes = slopes[:, parameters.free].toarray()
    vector = parameters.vector(face.start)
    before = face.errors(face.start, laid)
    alike = []
    first = len(parameters.heights)
    for number in range(first, first + int(parameters.weights.sum()), 5):
        tried = vector.copy()
        tried[number] += 0.01 if tried[number] < 0.5 else -0.01
        change = face.errors(parameters.values(tried, face.start), laid) - before
        change /= tried[number] - vector[number]
        told = slopes[:, number - first]
        if np.abs(change).max() > 0.1:
            alike.append(
                float(change @ told / (np.linalg.norm(change) * np.linalg.norm(told) + 1e-12))
            )
    assert np.median(alike) > 0.9


def test_the_solver_keeps_bounds_and_its_prior():
    from scipy import sparse

    matrix = sparse.csr_matrix(np.eye(3))
    wanted = np.array([0.5, 2.0, 0.2])
    prior = sparse.csr_matrix(np.diag([1e-3, 1e-3, 100.0]))
    found = solve(
        np.zeros(3), prior, (np.zeros(3), np.ones(3)), lambda x: x - wanted, lambda _: matrix
    )
    assert found == pytest.approx([0.5, 1.0, 0.0], abs=0.01)


def test_confidence_is_one_for_a_change_that_all_parts_show():
    start, value = np.zeros(2), np.array([0.2, 0.1])
    assert confidence(start, value, [value, value, value]) == 1
    assert confidence(start, value, [-value, value, 3 * value]) < 0.3
    assert confidence(start, value, [value]) == 0


def test_rates_fall_for_long_captures():
    *_, lines = example(lines=4)
    assert fit_rate(lines) == FPS
    assert fit_rate(lines * 40) < FPS
    assert fit_rate(lines * 400) == 30


# The command


def save(folder, lines, truth, said):
    """Write captures as CSV files with timings beside them."""
    folder.mkdir()
    for line, schedule in zip(lines, said, strict=True):
        animation = truth.perform(schedule, FPS)
        replace(animation, weights=line.values.clip(0, 1)).save(folder / f"{line.name}.csv")
        line.schedule.save(folder / f"{line.name}.TextGrid")


def test_the_command_writes_a_proposal_and_tells_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    _, _, truth, said, lines = example(lines=2, jitter=0.0, sounds=19)
    save(tmp_path / "captures", lines, truth, said)
    arguments = ["bank", "fit", "captures", "-l", "english", "-c", "facefx", "--workers", "1"]
    assert main([*arguments, "-o", "fit.json", "--page", "fit.html"]) == 0
    told = capsys.readouterr()
    page = (tmp_path / "fit.html").read_text("utf-8")
    assert page.count('<details class="of"') == 2
    assert "targets." in page
    assert "generalises" in page
    assert main([*arguments, "-o", "same", "--page", "same"]) == 2
    assert "same: the proposal and the page need different files" in capsys.readouterr().err
    assert "accepted: on held-out lines" in told.out
    assert "bank accept fit.json" in told.err
    proposal = read_fit(tmp_path / "fit.json")
    assert proposal.poseset == "facefx"
    assert proposal.lines == 2
    assert main([*arguments, "--json"]) == 0
    assert (
        json.loads(capsys.readouterr().out)["items"]
        == json.loads((tmp_path / "fit.json").read_text("utf-8"))["items"]
    )


def test_the_command_refuses_with_exit_code_1(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    _, _, truth, said, lines = example(lines=4, jitter=0.0)
    save(tmp_path / "captures", lines[:1], truth, said[:1])
    assert main(["bank", "fit", "captures", "-l", "english", "-c", "facefx"]) == 1
    assert "REFUSED: a single line" in capsys.readouterr().out


def test_the_command_says_what_no_capture_can_be_used_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "captures").mkdir()
    (tmp_path / "captures" / "a.csv").write_text("time_s,open\n0,0\n0.1,1\n0.2,0\n", "utf-8")
    assert main(["bank", "fit", "captures", "-l", "english", "-c", "facefx"]) == 2
    assert "no capture can be used" in capsys.readouterr().err
