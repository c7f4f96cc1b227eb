"""Layers, statuses and gaps of a language-character pair."""

from dataclasses import replace
from pathlib import Path

import pytest
from lanes import full

from lipsync_lang import PackError, resolve
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.library import Library
from lipsync_lang.pipeline.motion import PRESETS, Motion
from lipsync_lang.resolver.compile import compile_pair

POINTS = "[[0, 0], [0.5, 0.4], [1, 0]]"


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def bank(folder: Path, name: str, bigrams: str, *, language: str = "null") -> None:
    write(
        folder / "posesets" / "facefx" / "banks" / f"{name}.yaml",
        f"kind: bank\nformat: 1\nname: {name}\nposeset: facefx\nlanguage: {language}\n"
        f"bigrams:\n{bigrams}",
    )


def compiled(folder: Path, language: str = "english", character: str = "facefx"):
    return compile_pair(Library([folder], project=None), language, character)


def origin(pair, made):
    return next(o for o in made.origins if o.pair == pair)


def test_english_alone_is_441_bigrams_and_42_with_silence(tmp_path):
    report = compiled(tmp_path).report
    assert (report.shared, report.extra, report.added) == (441, 0, ())
    assert sum(sum(s.values()) for s in report.layers.values()) == 441
    assert sum(sum(s.values()) for s in report.silence_layers.values()) == 42
    assert not report.gaps


def test_a_language_with_one_phoneme_more_adds_43_bigrams_and_shares_the_rest(tmp_path):
    write(
        tmp_path / "languages" / "rounded.yaml",
        "kind: language\nformat: 1\nname: rounded\ntag: qaa\nadds: [yu]\n"
        "notations:\n  ipa: {y: yu, a: aa, m: bmp}\n",
    )
    report = compiled(tmp_path, "rounded").report
    assert (report.shared, report.extra, report.added) == (441, 43, ("yu",))


def test_the_first_layer_that_has_a_bigram_wins(tmp_path):
    bank(
        tmp_path,
        "shared",
        f"  l-ow: {{curves: {{open: {POINTS}}}}}\n  d-ow: {{status: approved, curves: {{}}}}\n",
    )
    bank(tmp_path, "english", f"  l-ow: {{curves: {{W: {POINTS}}}}}\n", language="english")
    made = compiled(tmp_path)
    assert origin(("l", "ow"), made).layer == "language"
    assert origin(("d", "ow"), made).layer == "shared"
    assert made.report.layers["shared"] == {"approved": 1}
    assert made.report.layers["draft"] == {"drafted": 439}

    write(
        tmp_path / "characters" / "anna.yaml",
        "kind: character\nformat: 1\nname: anna\nposeset: facefx\nbanks: [anna-bank.yaml]\n"
        f"bigrams:\n  l-ow: {{status: drafted, curves: {{wide: {POINTS}}}}}\n",
    )
    write(
        tmp_path / "characters" / "anna-bank.yaml",
        "kind: bank\nformat: 1\nname: anna-bank\nposeset: facefx\n"
        f"bigrams:\n  l-ow: {{curves: {{}}}}\n  d-ow: {{curves: {{open: {POINTS}}}}}\n",
    )
    made = compiled(tmp_path, character="anna")
    assert origin(("l", "ow"), made).layer == "character"
    assert origin(("l", "ow"), made).status == "drafted"
    assert made.report.layers["character"] == {"drafted": 1, "edited": 1}
    place = origin(("l", "ow"), made).places[0]
    file, line, _ = place.rsplit(":", 2)
    assert "l-ow" in Path(file).read_text().splitlines()[int(line) - 1]


def test_an_added_phoneme_borrows_the_edited_bigrams_of_the_one_it_is_like(tmp_path):
    bank(tmp_path, "shared", f"  l-w: {{word: loo, curves: {{open: {POINTS}}}}}\n")
    write(
        tmp_path / "languages" / "rounded.yaml",
        "kind: language\nformat: 1\nname: rounded\ntag: qaa\nadds: [yu]\n"
        "notations:\n  ipa: {y: yu}\n",
    )
    made = compiled(tmp_path, "rounded")
    assert origin(("l", "yu"), made).layer == "like"
    assert origin(("l", "w"), made).layer == "shared"
    assert origin(("d", "yu"), made).layer == "draft"


def test_a_phoneme_of_ones_own_keeps_the_contact_and_targets_of_what_it_is_like(tmp_path):
    write(
        tmp_path / "languages" / "apart.yaml",
        "kind: language\nformat: 1\nname: apart\ntag: qab\nextends: english\n"
        "adds: {nm: {title: hummed, like: bmp, class: nasal}}\n"
        "notations:\n  arpabet: {M: nm}\n",
    )
    made = compiled(tmp_path, "apart")
    assert made.notations["arpabet"]["M"] == (("nm", 1.0),)
    assert made.notations["arpabet"]["B"] == (("bmp", 1.0),)
    assert made.report.extra == 43
    number = made.phonemes.index("nm")
    assert any(contact.phonemes[number] for contact in made.tables.contacts)
    assert not made.report.gaps


def test_a_project_adds_banks_to_a_pose_set_that_it_does_not_own(tmp_path, monkeypatch):
    bank(tmp_path, "ours", f"  l-ow: {{curves: {{open: {POINTS}}}}}\n")
    monkeypatch.chdir(tmp_path)
    made = compile_pair(Library(), "english", "facefx")
    assert origin(("l", "ow"), made).layer == "shared"


def test_a_shadowed_pose_set_takes_its_banks_with_it(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    bank(second, "theirs", f"  l-ow: {{curves: {{open: {POINTS}}}}}\n")
    write(
        first / "posesets" / "facefx" / "poseset.yaml",
        "kind: poseset\nformat: 1\nname: facefx\nposes: {jaw: {}}\ntargets: {aa: {jaw: 1}}\n",
    )
    made = compile_pair(Library([first, second], project=None), "english", "facefx")
    assert origin(("l", "ow"), made).layer == "gap"


def test_gaps_are_an_error_that_names_them_or_rest_as_the_caller_says(tmp_path):
    write(
        tmp_path / "posesets" / "eel" / "poseset.yaml",
        "kind: poseset\nformat: 1\nname: eel\nposes: {gill: {}}\n"
        "targets: {aa: {gill: 1}, d: {gill: 0.2}}\n",
    )
    with pytest.raises(PackError, match=r"no curves for 437 bigrams of english: ah-ah, .*targets"):
        resolve("english", "eel", paths=[tmp_path], cache=False).stream()
    performer = resolve("english", "eel", paths=[tmp_path], cache=False, gaps="rest")
    assert len(performer.report.gaps) == 437
    assert performer.report.layers["draft"] == {"drafted": 4}


def test_an_edited_bigram_that_does_not_close_is_a_warning_at_its_line(tmp_path):
    bank(tmp_path, "shared", "  ah-bmp:\n    curves: {PBM: [[0, 0], [0.7, 0.5], [1, 0]]}\n")
    (warning,) = compiled(tmp_path).report.warnings
    assert "shared.yaml:7:3: W306" in warning
    assert "ah-bmp brings PBM to" in warning
    bank(tmp_path, "shared", "  ah-bmp: {contact: free, curves: {}}\n")
    assert not compiled(tmp_path).report.warnings


def test_two_faults_in_two_files_come_at_once(tmp_path):
    bank(tmp_path, "a", "  l-ow: {curves: {opne: [[0, 0], [1, 0]]}}\n")
    bank(tmp_path, "b", "  l-ow: {curves: {wode: [[0, 0], [1, 0]]}}\n")
    with pytest.raises(
        PackError, match=r"(?s)opne.*did you mean 'open'.*wode.*did you mean 'wide'"
    ):
        compiled(tmp_path)


@full
def test_a_bank_for_another_languages_phonemes_does_not_matter_here(tmp_path):
    bank(tmp_path, "other", "  l-qq: {curves: {}}\n")
    with pytest.raises(PackError, match=r"P202 unknown phoneme 'qq'"):
        compiled(tmp_path)
    write(
        tmp_path / "languages" / "foreign.yaml",
        "kind: language\nformat: 1\nname: foreign\ntag: qaa\nadds: {qq: {title: a click}}\n",
    )
    assert compiled(tmp_path).report.layers["draft"] == {"drafted": 441}


def test_a_characters_bank_cannot_lie_outside_the_packs(tmp_path):
    write(tmp_path / "outside.yaml", "kind: bank\nformat: 1\nname: outside\nposeset: facefx\n")
    write(
        tmp_path / "packs" / "characters" / "anna.yaml",
        "kind: character\nformat: 1\nname: anna\nposeset: facefx\nbanks: [../../outside.yaml]\n",
    )
    with pytest.raises(PackError, match="P213"):
        compiled(tmp_path / "packs", character="anna")


def test_a_language_has_a_motion_of_its_own_which_a_character_refines(tmp_path):
    head = "kind: language\nformat: 1\ntag: en-x-slow\nextends: paper-english\n"
    write(tmp_path / "languages" / "same.yaml", f"{head}name: same\n")
    write(tmp_path / "languages" / "slow.yaml", f"{head}name: slow\nmotion: {{speed_limit: 5}}\n")
    write(
        tmp_path / "characters" / "anna.yaml",
        "kind: character\nformat: 1\nname: anna\nposeset: facefx\nmotion: {window: 0.1}\n",
    )
    paper = PRESETS["paper"]
    for language, motion in (
        ("paper-english", replace(paper, window=0.1)),
        ("same", replace(paper, window=0.1)),
        ("slow", Motion(speed_limit=5, window=0.1)),
    ):
        performer = resolve(language, "anna", paths=[tmp_path], cache=False)
        assert performer.motion == motion, language
        called = resolve(language, "anna", paths=[tmp_path], cache=False, motion="default")
        assert called.motion == Motion()


def test_motion_is_refined_by_pose_set_character_and_call(tmp_path):
    write(
        tmp_path / "characters" / "slow.yaml",
        "kind: character\nformat: 1\nname: slow\nposeset: facefx\n"
        "motion: {preset: paper, speed_limit: 5}\n",
    )
    performer = resolve("english", "slow", paths=[tmp_path], cache=False, motion={"window": "0.2"})
    assert (performer.motion.warp, performer.motion.smooth) == ("linear", "chord")
    assert (performer.motion.speed_limit, performer.motion.window) == (5, 0.2)


def test_a_faulty_pack_tells_all_its_faults_when_it_is_used(tmp_path):
    text = (built_in() / "posesets" / "facefx" / "poseset.yaml").read_text()
    text = text.replace("threshold: 1,", "threshold: 5,", 1).replace("{FV: 0.8", "{VF: 0.8")
    write(tmp_path / "posesets" / "facefx" / "poseset.yaml", text)
    with pytest.raises(PackError, match=r"(?s)P104.*at most 2.*P201 unknown pose 'VF'"):
        compiled(tmp_path)


def test_an_unsound_language_is_refused_for_each_character(tmp_path):
    path = tmp_path / "languages/odd.yaml"
    path.parent.mkdir()
    head = "kind: language\nformat: 1\nname: odd\ntag: qaa\nextends: english\n"
    path.write_text(head + "words: {odd: {phonemes: [nowhere]}}\n")
    library = Library(project=tmp_path)
    for character in ("facefx", "crab"):
        with pytest.raises(PackError, match="nowhere"):
            compile_pair(library, "odd", character)
