"""`languages check`: a report for the author of a language, who need not write code."""

import json
import re
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from face_models import ARKIT, face
from lanes import full, swept
from places import ROOT
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.authoring import language_check
from lipsync_lang.authoring.language_check import (
    FAINTEST_WEIGHT,
    MOST_SOUNDS,
    check_language,
    draw_mouths,
    mouths_in,
    mouths_of,
    mouths_to_draw,
)
from lipsync_lang.authoring.sound_table import SoundTable
from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.performing.resolving import resolve

PACK = """kind: language
format: 1
name: stage-english
tag: en-x-stage
extends: english
notations:
  ipa: {ŋ: kg}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("languages").mkdir()
    Path("languages/stage-english.yaml").write_text(PACK, "utf-8")
    return tmp_path


@pytest.mark.parametrize("name", swept(LANGUAGES, quick=LANGUAGES[::20]))
def test_every_sound_of_every_language_has_a_mouth(name):
    found = check_language(LIBRARY, LIBRARY.find("language", name), "facefx")
    assert found.sound
    mouths = mouths_in(found.sounds)
    assert mouths
    assert {phoneme for mouth in mouths for phoneme in mouth} <= found.mouths.keys()
    assert all(row["need"] != "unmapped" for own in mouths.values() for row in own)
    told = str(found).split("\n")
    assert sum(line.startswith("  ") for line in told) >= len(mouths) + 1


def test_a_pack_keeps_the_tests_of_the_pack_that_it_shadows(cli):
    tests = len(LIBRARY.language("finnish").model.tests)
    head = "kind: language\nformat: 1\nname: finnish\ntag: fi\nextends: finnish\n"
    path = Path("languages/finnish.yaml")
    for mapping, ends in (("m: bmp", 0), ("m: ow", 1)):
        path.write_text(f"{head}notations:\n  ipa: {{{mapping}}}\n", "utf-8")
        assert cli("validate", "--no-tests").code == ends
        told = cli("languages", "check", str(path))
        assert told.code == ends
        passed = re.search(r"(\d+) of (\d+) tests pass", told.out)
        assert int(passed[2]) == tests
        assert (int(passed[1]) < tests) == ends
    assert re.search(r"languages/finnish.yaml:\d+:5: P221 .*'ulkomailta'", told.out)
    assert f"or state this test again in {path}" in told.out
    path.write_text(
        path.read_text("utf-8") + "tests:\n  - {text: ulkomailta, phonemes: [w, l]}\n", "utf-8"
    )
    told = cli("languages", "check", str(path))
    assert f"{path}:9:5: P221 'ulkomailta' becomes" in told.out
    assert len(re.findall("P221.*ulkomailta", told.out)) == 1
    assert f"of {tests} tests pass" in told.out


def test_a_pack_is_checked_by_its_file_or_its_name(cli):
    by_file = cli("languages", "check", "languages/stage-english.yaml", "-c", "facefx")
    by_name = cli("languages", "check", "stage-english", "-c", "facefx")
    assert by_file.code == by_name.code == 0, by_file.err
    assert by_file.out == by_name.out
    rows = {line.split()[0]: line for line in by_file.out.split("\n") if line.startswith("  ")}
    assert "ŋ" in rows["kg"], "the pack's own mapping"
    assert "ng" not in rows
    assert "PBM 0.85" in rows["bmp"]
    assert "lips pressed together" in rows["bmp"]
    assert "0 faults, 0 warnings" in by_file.err


def test_weights_are_those_of_the_targets():
    targets = LIBRARY.poseset("facefx").model.targets
    mouths = mouths_of(LIBRARY, "english", "facefx")
    for phoneme, steps in targets.items():
        if phoneme in mouths:
            for pose, weight in steps[0].weights.items():
                if weight == max(step.weights.get(pose, 0) for step in steps) and weight >= 0.05:
                    assert f"{pose} {weight:.2f}" in mouths[phoneme]


def test_the_largest_poses_come_first_and_the_faintest_are_left_out(monkeypatch):
    weights = {"low": FAINTEST_WEIGHT - 0.01, "wide": 0.2, "open": 0.6, "round": FAINTEST_WEIGHT}
    targets = {"seen": np.array([[*weights.values()]]), "still": np.zeros((1, len(weights)))}
    shelf = SimpleNamespace(
        poses=[*weights],
        targets={name: (SimpleNamespace(weights=own), None) for name, own in targets.items()},
    )
    monkeypatch.setattr("lipsync_lang.resolver.layers.PairPacks.open", lambda *_: shelf)
    mouths = mouths_of(LIBRARY, "english", "facefx")
    assert mouths == {"seen": "open 0.60, wide 0.20, round 0.05", "still": language_check.REST}


def test_faults_come_before_the_table(cli):
    path = Path("languages/stage-english.yaml")
    path.write_text(PACK.replace("ŋ: kg", "ŋ: gk").replace("tag: en-x-stage", "tag: 7"), "utf-8")
    ended = cli("languages", "check", path)
    assert ended.code == 1
    assert len(ended.out.strip().split("\n")) >= 2
    assert all("stage-english.yaml:" in line or "hint:" in line for line in ended.out.splitlines())
    assert "mouth" not in ended.out


def test_a_failing_test_is_counted_and_located(cli):
    path = Path("languages/stage-english.yaml")
    path.write_text(PACK + "tests:\n  - {text: sing, phonemes: [s, ih, d]}\n", "utf-8")
    ended = cli("languages", "check", path)
    assert ended.code == 1
    assert "stage-english.yaml:9" in ended.out
    assert "0 of 1 tests pass" in ended.out


def test_json_says_the_same(cli):
    told = json.loads(cli("languages", "check", "stage-english", "-c", "facefx", "--json").out)
    assert told["faults"] == []
    assert told["character"] == "facefx"
    assert told["mouths"]["bmp"].startswith("PBM 0.85")
    assert {row["label"] for row in told["sounds"]["rows"]} >= {"ŋ", "NG"}


def test_rows_are_short_and_begin_with_sounds_that_words_show():
    mouths = mouths_in(english_sounds())
    assert max(map(len, mouths.values())) > MOST_SOUNDS
    for own in mouths.values():
        shown = [bool(row["words"]) for row in own]
        assert shown == sorted(shown, reverse=True)
    found = check_language(LIBRARY, LIBRARY.find("language", "english"))
    assert "bmp" not in found.told(table=False)
    rows = str(found).split("\n")
    (row,) = (row for row in rows if row.startswith("  bmp "))
    assert f" + {len(mouths['bmp',]) - MOST_SOUNDS} " in row
    assert len(row.split(" + ")[0].split()) == 1 + MOST_SOUNDS


def test_a_mapping_against_its_features_needs_a_look(cli):
    path = Path("languages/stage-english.yaml")
    path.write_text(PACK.replace("ŋ: kg", "m͡ɲ: ih"), "utf-8")
    ended = cli("languages", "check", path)
    assert ended.code == 0
    assert "stage-english.yaml:7" in ended.out
    assert re.search("look at:\n  m͡ɲ: .*closure", ended.out)
    assert "0 faults, 1 warning" in ended.err


def test_texts_that_nothing_reads_are_told(cli):
    path = Path("languages/mute.yaml")
    tests = "tests:\n  - {text: oh, phonemes: [ow]}\n"
    path.write_text(PACK.replace("stage-english", "mute") + tests, "utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lipsync_lang.authoring.trial.Speaker", refusing)
        ended = cli("languages", "check", path)
    assert "1 of 1 tests pass; texts were not read: no voice here" in ended.out


def refusing(*_, **__):
    raise LipsyncError("no voice here")


def test_each_still_shows_its_own_mouth(monkeypatch):
    drawn = []

    def moments(animation, seconds, _, **options):
        drawn.append((animation.schedule, seconds, options))

    monkeypatch.setattr("lipsync_lang.render.sheet.moments", moments)
    sounds = english_sounds()
    draw_mouths([resolve("english", "facefx")], mouths_to_draw(sounds), BytesIO())
    ((schedule, seconds, options),) = drawn
    captions = options.pop("captions")
    assert options == {"close": True}
    alone = [own[0] for mouth, own in mouths_in(sounds).items() if len(mouth) == 1]
    for row, at, caption in zip(alone, seconds, captions, strict=True):
        number = int(np.searchsorted(schedule.times, at)) - 1
        assert schedule.labels[number] == row["label"]
        assert at == pytest.approx(schedule.times[number : number + 2].mean())
        assert caption == (row["label"], next(iter(row["words"]), ""))


def test_a_language_without_sounds_has_no_picture():
    sounds = english_sounds()
    with pytest.raises(OutputError, match="maps no sounds"):
        mouths_to_draw({**sounds, "rows": []})


def test_named_sounds_are_drawn_in_their_order():
    shown = mouths_to_draw(english_sounds(), ["k", "UW", "th", "aa", "uː"])
    assert [row["to"] for row in shown] == [["kg"], ["w"], ["th"], ["aa"], ["w"]]
    assert shown[-1]["label"] == "uː"
    told = [("k", "cat"), ("UW", "too"), ("th", "tongue tip between the teeth")]
    assert [row["caption"] for row in shown[:3]] == told
    with pytest.raises(OutputError, match="english has no sound 'thh'; did you mean 'th'"):
        mouths_to_draw(english_sounds(), ["aa", "thh"])


def test_common_names_of_sounds_serve_every_language():
    named = ("aa", "iy", "uw", "UW", "m", "f", "s", "h", "k", "y")
    for language in ("german", "mandarin"):
        sounds = SoundTable(LIBRARY, LIBRARY.extended(LIBRARY.find("language", language))).told()
        rows = dict(zip(named, mouths_to_draw(sounds, named), strict=True))
        assert {name: row["caption"][0] for name, row in rows.items()} == {n: n for n in named}
        assert rows["uw"]["to"] == rows["UW"]["to"] == ["w"]
        assert rows["uw"]["caption"][1] == "lips rounded and pushed forward"
        assert rows["y"]["to"] == ["yu"], "the vowel of the IPA before a romanisation"
        assert mouths_to_draw(sounds, ["th"])[0]["to"] == ["th"], "before an aspirated t"
    sounds["rows"] = [row for row in sounds["rows"] if "w" not in row["to"]]
    with pytest.raises(OutputError, match=r"no sound 'uw' \(lips rounded .*\); it has .*, f, t, "):
        mouths_to_draw(sounds, ["uw"])


@full
def test_the_mouths_are_drawn(cli, monkeypatch):
    from PIL import Image

    alone = [one for one in mouths_in(english_sounds()).items() if len(one[0]) == 1]
    monkeypatch.setattr(language_check, "mouths_in", lambda _: dict(alone[:9]))
    ended = cli("languages", "check", "stage-english", "-c", "facefx", "--picture", "mouths.png")
    assert ended.code == 0, ended.err
    with Image.open("mouths.png") as picture:
        height = picture.height
        width = picture.width
    assert 2 * 320 < height < 3 * 400, "eight stills in a row at most"
    assert 5 * 320 < width < 5 * 400, "rows of five and four"
    assert "bmp" not in ended.out, "a picture shows the table"
    assert "tests" in ended.out


def test_a_model_shows_the_mouths_of_the_pose_set_that_fits_it(cli, tmp_path):
    head = face(tmp_path / "head.glb", *ARKIT)
    ended = cli("languages", "check", "stage-english", "-c", head)
    assert ended.code == 0, ended.err
    assert "jawOpen 0." in ended.out


@full
def test_characters_are_drawn_side_by_side(cli):
    from PIL import Image

    head = ROOT / "posesets" / "crab" / "model.glb"
    sizes = {}
    for name, more in (("one", ()), ("two", ("--beside", "crab", "--beside", head))):
        options = ("-c", "facefx", "--sounds", "aa,m", "--picture", f"{name}.png", *more)
        ended = cli("languages", "check", "stage-english", *options)
        assert ended.code == 0, ended.err
        with Image.open(f"{name}.png") as picture:
            sizes[name] = picture.size
    assert sizes["two"][0] == sizes["one"][0]
    assert 3 * sizes["one"][1] < sizes["two"][1] < 4 * sizes["one"][1], "names stand above"


def english_sounds():
    return check_language(LIBRARY, LIBRARY.find("language", "english")).sounds


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "languages check languages/NAME.yaml"),
        (("stage-english", "--picture", "m.png"), "name one with -c CHARACTER"),
        (("languages/none.yaml",), "no such file"),
        (("stage-english", "-c", "facef"), "did you mean 'facefx'?"),
        (("stage-english", "-c", "arkit", "--picture", "m.png"), "model"),
        (("stage-english", "-c", "facefx", "--sounds", "aa"), "name one with --picture FILE"),
        (("stage-english", "-c", "facefx", "--beside", "crab"), "name one with --picture FILE"),
    ],
)
def test_misuse_is_told_and_nothing_is_written(arguments, said, cli):
    ended = cli("languages", "check", *arguments)
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err
    assert not Path("m.png").exists()
