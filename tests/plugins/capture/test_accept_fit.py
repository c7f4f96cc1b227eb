"""Acceptance of a fit: single items or all, without changes to a person's values, and undo."""

import json
from pathlib import Path

import pytest
from packs_tree import put
from test_fit_file import ITEMS, proposal, written

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.plugins.capture.accept_fit import accept_fit, remove_fit
from lipsync_lang.plugins.capture.fit_file import FITTED, FitFold, FitItem, FitVerdict
from lipsync_lang.resolver.compile import compile_pair

ANNA = """\
# Anna, by hand
kind: character
format: 1
name: anna
poseset: facefx

words: {hello: {curves: {open: [[0, 0], [1, 1]]}}}   # as she says it
"""
NAMES = [one.item for one in ITEMS]
STEP = "{open: 0.1234, W: 0.2, status: fitted}"
CURVES = "{open: [[0, 0], [1, 0.2]]}"


@pytest.fixture(autouse=True)
def anna(tmp_path, monkeypatch):
    """File of a character in a project, which is the current folder."""
    monkeypatch.chdir(tmp_path)
    return put(tmp_path, "characters/anna.yaml", ANNA) or tmp_path / "characters/anna.yaml"


def fit(*items, **others):
    return proposal(**{"language": "english", "items": items or ITEMS} | others)


def accept(*names, proposal=None, **options):
    return accept_fit(Library(), proposal or fit(), "anna", names, **options)


def states(done):
    return {row.item.item: row.state for row in done.rows}


def model():
    return Library().character("anna").model


def put_fit(folder, proposal):
    path = folder / "fit.json"
    path.write_text(written(proposal), "utf-8")
    return path


# What is accepted


def test_all_items_go_into_the_file_of_the_character_and_it_stays_sound(anna):
    done = accept(every=True)
    assert done.taken == tuple(NAMES)
    assert not list(validate(Library()))
    text = anna.read_text("utf-8")
    assert text.startswith(ANNA.rstrip("\n"))
    made = model()
    assert made.targets["ow"][0].weights == {"open": 0.5, "W": 0.4}
    assert [step.status for step in made.targets["ow"]] == ["fitted", None]
    assert made.softness == {"jaw": 0.05}
    assert made.anticipate == {"W": 0.1}
    assert made.motion.speed_limit == 14
    assert made.fitted == {"softness.jaw": 0.05, "anticipate.W": 0.1, "motion.speed_limit": 14}
    assert (made.bigrams["l-ow"].status, made.bigrams["l-ow"].boundary) == ("fitted", 0.45)


def test_what_is_accepted_is_performed():
    before = compile_pair(Library(), "english", "anna")
    accept(every=True)
    after = compile_pair(Library(), "english", "anna")
    at = {pose: number for number, pose in enumerate(after.poses)}
    assert after.motion.speed_limit == 14 != before.motion.speed_limit
    assert after.tables.softness[at["open"]] == 0.05 != before.tables.softness[at["open"]]
    assert after.tables.anticipate[at["W"]] == 0.1 != before.tables.anticipate[at["W"]]
    origins = {"-".join(one.pair): one for one in after.origins}
    assert (origins["l-ow"].layer, origins["l-ow"].status) == ("character", "fitted")
    assert any("anna.yaml" in place for place in origins["d-ow"].places)


@pytest.mark.parametrize("name", sorted(NAMES))
def test_each_item_is_accepted_alone_and_taken_out_again(name, anna):
    assert accept(name).taken == (name,)
    assert {one for one, state in states(accept()).items() if state == "same"} == {name}
    assert remove_fit(Library(), "anna").taken == (name,)
    assert anna.read_text("utf-8") == ANNA


def test_many_items_of_a_field_have_a_line_each(anna):
    labels = ("aa", "eh", "ow", "ih", "w", "l")
    items = [FitItem(item=f"targets.{one}", value={"open": 0.1234, "W": 0.2}) for one in labels]
    accept(every=True, proposal=fit(*items))
    lines = anna.read_text("utf-8").splitlines()
    assert lines[7:] == ["targets:", *(f"  {one}: {STEP}" for one in labels)]
    remove_fit(Library(), "anna")
    assert anna.read_text("utf-8") == ANNA


def test_taking_all_out_leaves_the_file_as_it_was(anna):
    accept(every=True)
    some = remove_fit(Library(), "anna", ["softness.jaw", "targets.ow"])
    assert set(some.taken) == {"softness.jaw", "targets.ow"}
    rest = remove_fit(Library(), "anna")
    assert set(rest.taken) == set(NAMES) - set(some.taken)
    assert anna.read_text("utf-8") == ANNA


def test_every_kind_of_item_is_among_those_tried():
    assert {item.kind for item in ITEMS} == set(FITTED)


def test_an_earlier_fit_is_replaced_by_a_later_one():
    accept(every=True)
    later = fit(
        FitItem(item="softness.jaw", value=0.07),
        FitItem(item="targets.ow", value={"open": 0.9}),
        FitItem(item="bigrams.l-ow", value={"curves": {"W": [[0, 0], [1, 1]]}}),
    )
    assert accept(every=True, proposal=later).taken == tuple(one.item for one in later.items)
    made = model()
    assert (made.softness["jaw"], made.fitted["softness.jaw"]) == (0.07, 0.07)
    assert made.targets["ow"][0].weights == {"open": 0.9}
    assert list(made.bigrams["l-ow"].curves) == ["W"]


def test_a_list_of_items_changes_nothing(anna):
    done = accept()
    assert (done.taken, set(states(done).values())) == ((), {"ready"})
    assert anna.read_text("utf-8") == ANNA


def test_a_dry_run_changes_nothing(anna):
    assert accept(every=True, write=False).taken == tuple(NAMES)
    assert anna.read_text("utf-8") == ANNA


# What stays


STAYS = {
    "targets.ow": "targets: {ow: {open: 0.9}}",
    "softness.jaw": "softness: {jaw: 0.06}",
    "anticipate.W": "anticipate: {W: 0.2}\nfitted: {anticipate.W: 0.1}",
    "motion.speed_limit": "motion: {speed_limit: 9}",
    "bigrams.l-ow": f"bigrams: {{l-ow: {{curves: {CURVES}}}}}",
}
assert set(STAYS) == set(NAMES)


@pytest.mark.parametrize("name", sorted(STAYS))
def test_what_a_person_wrote_stays_even_by_name(name, anna):
    text = f"{ANNA}{STAYS[name]}\n"
    anna.write_text(text, "utf-8")
    done = accept(name, every=True)
    assert done.taken == tuple(one for one in NAMES if one != name)
    (left,) = done.left
    assert left.state == "stays"
    assert "a person" in left.why
    assert "anna.yaml:8:" in left.why
    at = text.splitlines()[7]
    assert at in anna.read_text("utf-8") or name.split(".")[0] in {"softness", "anticipate"}
    assert name not in remove_fit(Library(), "anna").taken


@pytest.mark.parametrize("status", ["approved", "edited"])
@pytest.mark.parametrize("layer", ["character", "language", "shared"])
def test_a_bigram_that_a_person_drew_in_any_layer_stays(layer, status, anna, tmp_path):
    language = "english" if layer == "language" else "null"
    head = f"kind: bank\nformat: 1\nname: own\nposeset: facefx\nlanguage: {language}\n"
    text = f"{head}bigrams: {{l-ow: {{status: {status}, curves: {CURVES}}}}}\n"
    if layer == "character":
        put(tmp_path, "characters/own.yaml", text)
        drafted = f"bigrams: {{l-ow: {{status: drafted, curves: {CURVES}}}}}\n"
        anna.write_text(f"{ANNA}banks: [own.yaml]\n{drafted}", "utf-8")
    else:
        put(tmp_path, "posesets/facefx/banks/own.yaml", text)
    done = accept("bigrams.l-ow")
    assert done.taken == ()
    assert f"a person drew it: {status} in" in done.left[0].why
    assert "own.yaml" in done.left[0].why


def test_a_bigram_that_a_drawn_parent_answers_stays(anna):
    anna.write_text(f"{ANNA}bigrams: {{l-ah: {{curves: {CURVES}}}}}\n", "utf-8")
    shade = next(k for k, one in Library().common().model.shades.items() if one.like == "ah")
    item = FitItem(item=f"bigrams.l-{shade}", value={"curves": {"open": [[0, 0], [1, 1]]}})
    assert states(accept(proposal=fit(item))) == {item.item: "stays"}


def test_a_draft_in_the_file_is_replaced_and_keeps_its_word(anna):
    drafted = f"{{word: low, status: drafted, interpolation: linear, curves: {CURVES}}}"
    anna.write_text(f"{ANNA}bigrams: {{l-ow: {drafted}}}\n", "utf-8")
    assert accept("bigrams.l-ow").taken == ("bigrams.l-ow",)
    made = model().bigrams["l-ow"]
    assert (made.word, made.status, made.interpolation) == ("low", "fitted", None)


def test_a_fitted_value_that_a_person_changed_is_the_persons(anna):
    accept("softness.jaw")
    text = anna.read_text("utf-8").replace("softness: {jaw: 0.05}", "softness: {jaw: 0.04}")
    anna.write_text(text, "utf-8")
    assert states(accept())["softness.jaw"] == "stays"
    assert remove_fit(Library(), "anna").taken == ()


def test_items_of_low_confidence_are_accepted_by_name_or_by_a_lower_bound():
    item = FitItem(item="softness.lips", value=0.03, confidence=0.4)
    assert states(accept(proposal=fit(item))) == {"softness.lips": "doubtful"}
    assert accept(proposal=fit(item), every=True, write=False).taken == ()
    assert accept(proposal=fit(item), every=True, confidence=0, write=False).taken
    assert accept("softness.lips", proposal=fit(item)).taken == ("softness.lips",)


UNKNOWN = {
    "targets.oww": ({"open": 1}, "unknown phoneme 'oww'"),
    "targets.aa": ({"opne": 1}, "unknown pose 'opne'; did you mean 'open'"),
    "targets.eh": ({"open": 1, "dominance": {"opne": 1}}, "unknown pose 'opne'"),
    "softness.jaws": (0.1, "unknown region 'jaws'; did you mean 'jaw'"),
    "anticipate.w": (0.1, "unknown pose 'w'; did you mean 'W'"),
    "bigrams.l-oww": ({"curves": {}}, "unknown phoneme 'oww'"),
    "bigrams.l-aa": ({"curves": {"opne": [[0, 0], [1, 1]]}}, "unknown pose 'opne'"),
}


@pytest.mark.parametrize("name", sorted(UNKNOWN))
def test_an_item_that_the_pose_set_does_not_know_is_refused_by_name(name):
    value, why = UNKNOWN[name]
    item = FitItem(item=name, value=value)
    done = accept(name, proposal=fit(item, ITEMS[1]), every=True)
    assert done.taken == ("softness.jaw",)
    assert [(row.item.item, row.state) for row in done.left] == [(name, "refused")]
    assert why in done.left[0].why


# What is refused as a whole


def test_a_fit_that_does_not_generalise_is_refused_with_its_numbers(anna):
    fold = FitFold(held_out="one", by="speaker", before=0.08, after=0.09)
    bad = fit(verdict=FitVerdict(accepted=False, why="worse on 1 of 1", folds=(fold,)))
    with pytest.raises(LipsyncError, match=r"worse on 1 of 1\n.*speaker one.*0\.080.*0\.090") as no:
        accept(every=True, proposal=bad)
    assert "--anyway" in str(no.value)
    assert anna.read_text("utf-8") == ANNA
    assert states(accept(proposal=bad))
    assert accept(every=True, proposal=bad, anyway=True).taken == tuple(NAMES)


def test_a_fit_for_another_pose_set_is_refused(anna):
    with pytest.raises(LipsyncError, match=r"for pose set 'arkit', but 'anna' moves.*'facefx'"):
        accept(every=True, proposal=fit(poseset="arkit"))
    assert anna.read_text("utf-8") == ANNA


def test_a_bare_pose_set_takes_no_fit():
    with pytest.raises(LipsyncError, match="characters new NAME --model FILE --poseset facefx"):
        accept_fit(Library(), fit(), "facefx", every=True)
    with pytest.raises(LipsyncError, match="'facefx' is a pose set"):
        remove_fit(Library(), "facefx")


def test_an_installed_character_takes_no_fit(tmp_path, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    put(tmp_path / "parts", "characters/anna.yaml", ANNA)
    monkeypatch.chdir(elsewhere)
    library = Library()
    root = library.roots[-1]._replace(path=tmp_path / "parts")
    monkeypatch.setattr(library, "roots", (*library.roots, root))
    with pytest.raises(LipsyncError, match="is installed; copy it"):
        accept_fit(library, fit(), "anna", every=True)


def test_an_item_that_is_not_in_the_fit_is_refused(anna):
    with pytest.raises(
        LipsyncError, match=r"unknown item 'softness\.jew'.*did you mean 'softness\.jaw'"
    ):
        accept("softness.jew")
    with pytest.raises(LipsyncError, match=r"unknown item 'softness\.jaw'"):
        remove_fit(Library(), "anna", ["softness.jaw"])
    assert anna.read_text("utf-8") == ANNA


def test_items_of_poses_that_are_gone_are_taken_out(anna):
    anna.write_text(f"{ANNA}targets: {{ow: {{gone: 1, status: fitted}}}}\n", "utf-8")
    assert [fault.code for fault in validate(Library())] == ["P201"]
    assert remove_fit(Library(), "anna").taken == ("targets.ow",)
    assert anna.read_text("utf-8") == ANNA


# The command


def test_the_command_lists_accepts_and_takes_out(anna, cli, tmp_path):
    path = put_fit(tmp_path, fit())
    listed = cli("bank", "accept", path, "-c", "anna")
    assert listed.code == 0
    assert [line.split()[0] for line in listed.out.splitlines()] == ["item", *NAMES]
    assert "0.080 -> 0.050" in listed.out
    assert "open 0.5, W 0.4 > W 0.9" in listed.out
    assert "5 of 5 items can be accepted with --all" in listed.err
    one = cli("bank", "accept", path, "softness.jaw", "-c", "anna")
    assert (one.code, one.out) == (0, "softness.jaw\n")
    assert "1 item put into" in one.err
    rest = cli("bank", "accept", path, "--all", "-c", "anna")
    assert rest.out.split() == [name for name in NAMES if name != "softness.jaw"]
    out = cli("bank", "accept", path, "softness.jaw", "--remove", "-c", "anna")
    assert (out.code, out.out) == (0, "softness.jaw\n")
    assert cli("bank", "accept", "--remove", "--all", "-c", "anna").code == 0
    assert anna.read_text("utf-8") == ANNA


def test_the_command_fails_for_a_named_item_that_stays(anna, cli, tmp_path):
    anna.write_text(f"{ANNA}softness: {{jaw: 0.06}}\n", "utf-8")
    path = put_fit(tmp_path, fit())
    named = cli("bank", "accept", path, "softness.jaw", "-c", "anna")
    assert named.code == 1
    assert "softness.jaw: a person wrote it" in named.err
    every = cli("bank", "accept", path, "--all", "-c", "anna")
    assert every.code == 0
    assert "softness.jaw: a person wrote it" in every.err


def test_the_command_accepts_the_doubtful_and_the_refused_only_if_asked(cli, tmp_path):
    bad = fit(
        FitItem(item="softness.lips", value=0.03, confidence=0.4),
        verdict=FitVerdict(accepted=False, why="worse on 3 of 3 lines"),
    )
    words = ("bank", "accept", put_fit(tmp_path, bad), "--all", "-c", "anna")
    refused = cli(*words)
    assert refused.code == 2
    assert "worse on 3 of 3 lines" in refused.err
    assert "worse on 3 of 3 lines" in cli(*words[:3], "-c", "anna").err
    assert cli(*words, "--anyway").out == ""
    assert cli(*words, "--anyway", "--confidence", "0.3").out == "softness.lips\n"


def test_the_command_tells_all_as_json(anna, cli, tmp_path):
    path = put_fit(tmp_path, fit())
    dry = json.loads(cli("bank", "accept", path, "--all", "--dry-run", "--json", "-c", "anna").out)
    assert dry["written"] is False
    assert [one["item"] for one in dry["items"] if one["accepted"]] == NAMES
    assert anna.read_text("utf-8") == ANNA
    done = json.loads(cli("bank", "accept", path, "--all", "--json", "-c", "anna").out)
    assert (done["written"], Path(done["file"]).name) == (True, "anna.yaml")
    gone = json.loads(cli("bank", "accept", "--remove", "--all", "--json", "-c", "anna").out)
    assert set(gone["removed"]) == set(NAMES)


def test_the_command_asks_for_what_is_missing(cli):
    assert "bank accept FIT.json" in cli("bank", "accept", "-c", "anna").err
    assert "give --all" in cli("bank", "accept", "--remove", "-c", "anna").err
    assert "a character is missing" in cli("bank", "accept", "fit.json").err
    assert "cannot be read" in cli("bank", "accept", "none.json", "-c", "anna").err
