"""Making a study: balanced, blind pairs, uniform clips, and resumed runs."""

import json
import re
import subprocess
import sys
from base64 import b64decode
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full

import lipsync_lang as ll
from lipsync_lang.plugins.study import methods as ways
from lipsync_lang.plugins.study import study_clips
from lipsync_lang.plugins.study.methods import (
    Method,
    StudyCharacter,
    parse_method,
    parse_methods,
    spoilt,
)
from lipsync_lang.plugins.study.study_clips import Clip, of_one_size, render_clips
from lipsync_lang.plugins.study.study_file import read_study
from lipsync_lang.plugins.study.study_lines import (
    StudyLine,
    in_balanced_order,
    laid_out,
    possible_pairs,
    study_lines,
)
from lipsync_lang.plugins.study.study_maker import StudyPlan, make_study
from lipsync_lang.plugins.study.study_page import PageTexts, origin_of, parse_asked, study_page
from lipsync_lang.text.lines.line_readers import Line

BOTH = ["zebra=keyframes", "yak=dominance"]
"""Methods with names that occur nowhere else in a page."""

NASTY = "</script><script>alert(1)</script>&\u2028{{CLIPS}}"


def schedule(name="AA"):
    return ll.Schedule(("M", name, "P", "_"), [0, 0.1, 0.3, 0.4, 0.6], notation="arpabet")


def face(character="facefx"):
    performer = ll.resolve("english", character)
    return StudyCharacter(performer, performer.model, lambda _: performer)


def lines(*names):
    return tuple(StudyLine(name, name, schedule(vowel)) for name, vowel in
                 zip(names, ("AA", "IY", "UW", "EH"), strict=False))  # fmt: skip


@pytest.fixture
def drawn(monkeypatch):
    """Write tokens instead of videos, and return the digests of rendered clips."""
    seen = []

    def render(folder, clip):
        seen.append(clip.digest)
        clip.path(folder).write_bytes(f"clip {clip.digest}".encode() + b"x" * (len(seen) % 3))

    monkeypatch.setattr(study_clips, "_render", render)
    return seen


def made(tmp_path, plan=None, **changed):
    plan = plan or StudyPlan(lines("one", "two"), (face(),), parse_methods(BOTH))
    return make_study(replace(plan, **changed), tmp_path / "study", workers=1)


def content_of(page):
    """Return the document of a page, and its clips by name."""
    found = dict(re.findall(r'<script type="text/plain" id="([^"]+)">([^<]*)</script>', page))
    document = re.search(
        r'<script type="application/json" id="document">(.*?)</script>', page, re.DOTALL
    )
    return json.loads(document[1]), {name: b64decode(text) for name, text in found.items()}


# Pairs

names = st.lists(st.sampled_from("abcdefgh"), min_size=1, max_size=6, unique=True)


@given(names, names, st.lists(st.sampled_from("xyzw"), min_size=2, max_size=4, unique=True),
       st.integers(), st.integers(1, 40))  # fmt: skip
def test_the_first_pairs_are_balanced_whatever_their_number(texts, faces, methods, seed, most):
    found = list(possible_pairs(texts, faces, methods, lambda *_: False))
    order = list(in_balanced_order(found, seed))
    assert sorted(order) == sorted(found)
    some = order[:most]
    for part in ("methods", "character"):
        counts = Counter(getattr(pair, part) for pair in found)
        seen = [Counter(getattr(pair, part) for pair in some)[one] for one in counts]
        assert max(seen) - min(seen) <= 1 or len(some) == len(found)
    assert list(in_balanced_order(found, seed)) == order


@given(names, st.integers())
def test_the_first_pairs_show_each_line_once(texts, seed):
    found = possible_pairs(texts, ["c"], ["x", "y", "z"], lambda *_: False)
    first = list(in_balanced_order(found, seed))[: len(texts)]
    assert sorted(pair.line for pair in first) == sorted(texts)


@given(st.integers(), names, st.integers(1, 60))
def test_no_method_is_tied_to_a_side_on_any_character(seed, faces, count):
    found = possible_pairs([str(n) for n in range(10)], faces, ["x", "y"], lambda *_: False)
    pairs = laid_out(list(in_balanced_order(found, seed))[:count], 0, seed)
    lefts = Counter((pair.character, pair.left) for pair in pairs)
    for face in faces:
        assert abs(lefts[face, "x"] - lefts[face, "y"]) <= 1


@given(st.integers(), names, st.integers(1, 30), st.integers(0, 6))
def test_each_method_stands_left_as_often_as_right(seed, faces, count, checks):
    found = possible_pairs([str(n) for n in range(30)], faces, ["x", "y"], lambda *_: False)
    some = list(in_balanced_order(found, seed))[:count]
    pairs = laid_out(some, checks, seed)
    assert [pair.pair for pair in pairs] == [f"p{n:03}" for n in range(1, count + checks + 1)]
    lefts = Counter(pair.left for pair in pairs if pair.check is None)
    assert abs(lefts["x"] - lefts["y"]) <= 1
    sides = Counter(pair.check for pair in pairs)
    assert sides[None] == count
    assert abs(sides["left"] - sides["right"]) <= 2
    assert all(pair.left == pair.right for pair in pairs if pair.check)
    assert laid_out(some, checks, seed) == pairs


def test_another_seed_makes_another_order():
    found = list(possible_pairs(list("abcdefgh"), ["c"], ["x", "y"], lambda *_: False))
    orders = {laid_out(list(in_balanced_order(found, seed)), 1, seed) for seed in range(5)}
    assert len(orders) == 5


# Methods


@pytest.mark.parametrize(("text", "told"), [
    ("keyframe", "did you mean 'keyframes'"), ("x=nowhere", "there is no folder 'nowhere'"),
    ("=ours", "write NAME=SOURCE"), ("x=motion:", "there is no folder 'motion:'"),
    ("x=held:nowhere", "there is no folder 'nowhere'"),
])  # fmt: skip
def test_an_unknown_method_is_refused(text, told):
    with pytest.raises(ll.LipsyncError, match=re.escape(told)):
        parse_method(text)


@pytest.mark.parametrize(("texts", "told"), [
    (["ours"], "two methods or more"), ([], "two methods or more"),
    (["ours", "ours=held"], "'ours' is given twice"),
])  # fmt: skip
def test_a_study_has_two_methods_or_more(texts, told):
    with pytest.raises(ll.LipsyncError, match=told):
        parse_methods(texts)


def test_methods_are_named_by_source(tmp_path):
    assert parse_method("a=character:b") == Method("a", "character", "b")
    assert parse_method("held") == Method("held", "held")
    assert parse_method(f"a={tmp_path}") == Method("a", "files", str(tmp_path))
    assert parse_method(f"a=held:{tmp_path}") == Method("a", "files", str(tmp_path), "held")


@pytest.mark.parametrize("how", ["ours", "keyframes", "dominance", "held", "motion", "character"])
def test_every_method_has_the_frames_of_the_others_and_begins_at_rest(how):
    who = face()
    one = replace(who, other=lambda _: who.performer.with_motion("paper"))
    own = one.frames(schedule())
    made = one.animate(Method("m", how, "x"), "line", own)
    assert np.array_equal(made.times, own.times)
    assert made.columns == own.columns
    assert (made.model, made.fps) == (own.model, own.fps)
    assert made.weights[[0, -1]].max() <= 1e-9
    assert made.weights.max() > 0.2
    assert np.array_equal(made.weights, own.weights) == (how == "ours")


def test_files_of_other_programs_take_part(tmp_path):
    who = face()
    own = who.frames(schedule())
    performed = who.performer.perform(schedule(), fps=30)
    for folder, name in (("csv", "a.csv"), ("json", "a.json"), ("glb", "a.glb")):
        (tmp_path / folder).mkdir()
        who.performer.rigged(performed).save(tmp_path / folder / name)
    (tmp_path / "rhubarb").mkdir()
    cues = [{"start": 0, "end": 0.1, "value": "A"}, {"start": 0.1, "end": 0.4, "value": "D"},
            {"start": 0.4, "end": 0.6, "value": "X"}]  # fmt: skip
    (tmp_path / "rhubarb/a.json").write_text(
        json.dumps({"metadata": {"soundFile": "a.wav", "duration": 0.6}, "mouthCues": cues})
    )
    for folder in ("csv", "json", "glb"):
        made = who.animate(parse_method(f"x={tmp_path / folder}"), "a", own)
        inside = (own.times > 0) & (own.times < 0.55)
        assert np.abs(made.weights - own.weights)[inside].max() < 1e-3, folder
    opened = [who.animate(parse_method(f"x={how}{tmp_path / 'rhubarb'}"), "a", own)
              for how in ("", "held:")]  # fmt: skip
    assert all(one.weights.max() > 0.3 for one in opened)
    assert not np.array_equal(opened[0].weights, opened[1].weights)


BANK = """
kind: bank
format: 1
name: loud
poseset: facefx
language: null
bigrams:
  bmp-aa: {status: edited, curves: {open: [[0, 1], [1, 1]]}}
"""


def test_a_bank_takes_part(tmp_path):
    bank = tmp_path / "loud.yaml"
    bank.write_text(BANK)
    who = face()
    louder = ways.with_bank(who.performer, "facefx", bank, lambda path: ll.resolve("english", path))
    own, other = (one.perform(schedule(), fps=30) for one in (who.performer, louder))
    assert other["open"].max() > own["open"].max() + 0.1
    with pytest.raises(ll.LipsyncError, match="cannot be read"):
        ways.with_bank(who.performer, "facefx", tmp_path / "none.yaml", lambda _: who.performer)


@pytest.mark.parametrize(("content", "told"), [
    ("time_s,open\n0,0\n5,1\n9,0\n", "ends at 9.0 s, but the line ends at 0.6 s"),
    ("time_s,nose\n0,0\n0.3,1\n0.6,0\n", "has nothing of"),
    ("word,start,end\nmap,0.1,0.5\n", "only times of words"),
])  # fmt: skip
def test_a_file_of_another_line_or_face_is_left_out_by_name(tmp_path, drawn, content, told):
    (tmp_path / "files").mkdir()
    (tmp_path / "files/one.csv").write_text(content)
    methods = parse_methods(["ours", "held", f"theirs={tmp_path / 'files'}"])
    plan = StudyPlan(lines("one", "two"), (face(),), methods)
    study = made(tmp_path, plan)
    assert any(told in remark and "one" in remark for remark in study.remarks), study.remarks
    assert "'theirs' has no file for two" in study.remarks[0]
    seen = {m for pair in study.study.pairs for m in (pair.left, pair.right)}
    assert seen == {"ours", "held"}
    assert drawn


def test_two_files_for_one_line_are_refused(tmp_path):
    for name in ("a.csv", "a.json"):
        (tmp_path / name).write_text("x")
    who = face()
    with pytest.raises(ll.LipsyncError, match=r"a.csv and a.json for one line"):
        who.animate(Method("m", "files", str(tmp_path)), "a", who.frames(schedule()))


def test_no_pair_at_all_is_an_error_that_says_why(tmp_path, drawn):
    (tmp_path / "empty").mkdir()
    methods = parse_methods(["ours", f"theirs={tmp_path / 'empty'}"])
    with pytest.raises(ll.LipsyncError, match=r"no pair can be shown\n.*'theirs' has no file for"):
        made(tmp_path, StudyPlan(lines("one"), (face(),), methods))
    assert not drawn


def test_the_wrong_clip_of_a_check_is_late_or_still():
    own = face().frames(schedule())
    late, still = spoilt(own, 0), spoilt(own, 1)
    assert not still.weights.any()
    busiest = own.weights.sum(axis=0).argmax()
    delay = np.argmax(late.weights[:, busiest]) - np.argmax(own.weights[:, busiest])
    assert delay / own.fps == pytest.approx(0.4, abs=0.05)


# Lines


def test_lines_are_named_by_their_id_or_their_place():
    found = [Line("Hello", "s.csv:2", "a"), Line("World", "dir/s.csv:3"), Line(" ", "s.csv:4")]
    named = study_lines(found, ["Bye"])
    assert [(line.name, line.text) for line in named] == [
        ("a", "Hello"), ("s_3", "World"), ("text_1", "Bye"),
    ]  # fmt: skip
    assert not any(line.recording for line in named)


def test_lines_without_a_recording_are_left_out_by_name(tmp_path):
    found, told = [Line("Hello", "s.csv:2", "a"), Line("World", "s.csv:3", "b")], []
    with pytest.raises(ll.LipsyncError, match="no recording with the name of a line"):
        study_lines(found, (), tmp_path)
    (tmp_path / "a.wav").write_bytes(b"")
    (line,) = study_lines(found, ["Bye"], tmp_path, told.append)
    assert (line.name, line.recording) == ("a", tmp_path / "a.wav")
    assert told == [
        f"{tmp_path}: has no recordings with the names b, text_1; these lines are left out"
    ]


@pytest.mark.parametrize(("found", "told"), [
    ([], "there is no line"),
    ([Line("a", "s:1", "x"), Line("b", "s:2", "x")], "2 lines have the name 'x'"),
])  # fmt: skip
def test_lines_without_a_name_of_their_own_are_refused(found, told):
    with pytest.raises(ll.LipsyncError, match=told):
        study_lines(found)


# The study in its folder


def test_a_page_tells_nothing_about_methods(tmp_path, drawn):
    study = made(tmp_path)
    page = (study.folder / "page.html").read_text("utf-8")
    document, clips = content_of(page)
    text = page + json.dumps(document)
    words = ["zebra", "yak", "keyframes", "dominance", "check", "one", "two"]
    rest = re.sub(r"<script>.*?</script>|<style>.*?</style>", "", text, flags=re.DOTALL)
    found = {word for word in words if re.search(rf'"{word}"|\b{word}-|>{word}<', rest)}
    assert not found
    assert not any(word in text for word in ("zebra", "yak", *set(drawn)))
    assert set(document["groups"][0]["pairs"]) == {pair.pair for pair in study.study.pairs}
    for pair in study.study.pairs:
        left, right = clips[f"{pair.pair}-left"], clips[f"{pair.pair}-right"]
        assert len(left) == len(right)
    assert len(clips) == 2 * len(study.study.pairs)


def test_each_side_shows_the_method_of_the_key(tmp_path, drawn):
    plan = StudyPlan(lines("one", "two", "three"), (face(),), parse_methods(BOTH), checks=2)
    study = made(tmp_path, plan)
    page = (study.folder / "page.html").read_text("utf-8")
    _, shown = content_of(page)
    who, methods = plan.characters[0], {method.name: method for method in plan.methods}
    spoilt_clips = 0
    for pair in study.study.pairs:
        own = who.frames({line.name: line for line in plan.lines}[pair.line].schedule)
        for side, method in (("left", pair.left), ("right", pair.right)):
            clip = Clip(who.animate(methods[method], pair.line, own), own)
            content = clip.path(study.folder / "clips")
            as_stated = content.exists() and shown[f"{pair.pair}-{side}"].startswith(
                content.read_bytes() + b"\0\0"
            )
            assert as_stated == (pair.check in (None, side)), (pair, side)
            spoilt_clips += not as_stated
    assert spoilt_clips == 2
    assert drawn


def test_the_key_is_read_and_its_digest_follows_the_clips(tmp_path, drawn, monkeypatch):
    study = made(tmp_path)
    assert read_study(study.folder / "study.json") == study.study
    assert all(pair.seconds == pytest.approx(1.0, abs=0.3) for pair in study.study.pairs)
    assert drawn
    monkeypatch.setattr(study_clips, "CLIP_FORM", "clip 0")
    with pytest.raises(ll.LipsyncError, match="contains another study"):
        made(tmp_path)


def test_a_killed_run_goes_on_where_it_stopped(tmp_path, drawn, monkeypatch):
    render = study_clips._render  # noqa: SLF001 of the module under test

    def dying(folder, clip):
        if len(drawn) == 2:
            raise KeyboardInterrupt
        render(folder, clip)

    monkeypatch.setattr(study_clips, "_render", dying)
    with pytest.raises(KeyboardInterrupt):
        made(tmp_path)
    first = list(drawn)
    assert not (tmp_path / "study/study.json").exists()
    monkeypatch.setattr(study_clips, "_render", render)
    study = made(tmp_path)
    assert len(set(drawn)) == len(drawn) == study.rendered + len(first)
    before = (study.folder / "page.html").read_bytes()
    again = made(tmp_path)
    assert (again.rendered, again.study) == (0, study.study)
    assert (again.folder / "page.html").read_bytes() == before


def test_a_folder_with_another_study_is_never_touched(tmp_path, drawn):
    study = made(tmp_path)
    files = {path: path.read_bytes() for path in study.folder.rglob("*") if path.is_file()}
    (study.folder / "answers.jsonl").write_text("kept\n")
    with pytest.raises(
        ll.LipsyncError, match=r"contains another study, 'Which face speaks better\?'"
    ):
        made(tmp_path, seed=2)
    for path, content in files.items():
        assert path.read_bytes() == content
    made(tmp_path)
    assert (study.folder / "answers.jsonl").read_text() == "kept\n"
    assert drawn


def test_raters_who_see_some_pairs_see_every_check(tmp_path, drawn):
    plan = StudyPlan(
        lines("a", "b", "c", "d"), (face(),), parse_methods(BOTH), checks=2, raters_see=3
    )
    study = made(tmp_path, plan)
    document, _ = content_of((study.folder / "page.html").read_text("utf-8"))
    checks = {pair.pair for pair in study.study.pairs if pair.check}
    assert [group["take"] for group in document["groups"]] == [2, 1]
    assert set(document["groups"][0]["pairs"]) == checks
    assert drawn


# Page


def test_texts_of_a_study_are_data(tmp_path, drawn):
    texts = PageTexts(NASTY, (parse_asked(f"Age{NASTY}: a|{NASTY}"),))
    study = made(tmp_path, title=NASTY, texts=texts)
    page = (study.folder / "page.html").read_text("utf-8")
    document, clips = content_of(page)
    assert "alert(1)</script>" not in page
    assert document["title"] == NASTY
    assert document["consent"] == [NASTY]
    assert len(clips) == 2 * len(study.study.pairs)
    assert drawn


@pytest.mark.parametrize(("texts", "told"), [
    (PageTexts(" \n"), "consent text must have"),
    (PageTexts("x" * 20_001), "between 1 and 20000 characters"),
    (PageTexts(asked=(parse_asked("Age"), parse_asked("age:"))), "each only once"),
    (PageTexts(post="ftp://x"), "is not a web address; give one such as"),
])  # fmt: skip
def test_texts_that_a_page_cannot_have_are_refused(tmp_path, texts, told):
    with pytest.raises(ll.LipsyncError, match=told):
        made(tmp_path, texts=texts)


@pytest.mark.parametrize("address", [
    "javascript:alert(1)", "https://", "https://a;script-src *", "http://u:p@x/", "https://a:x/",
    "http://[", "https://a b/",
])  # fmt: skip
def test_an_address_that_would_change_the_policy_is_refused(address):
    with pytest.raises(ll.LipsyncError, match="is not a web address"):
        origin_of(address)


def test_the_policy_allows_the_address_for_answers_alone(tmp_path, drawn):
    texts = PageTexts(post="https://example.org:8443/answers?x=1")
    page = (made(tmp_path, texts=texts).folder / "page.html").read_text("utf-8")
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', page)[1]
    assert "connect-src https://example.org:8443;" in policy
    assert "default-src 'none'" in policy
    assert drawn


def test_boxes_fill_the_smaller_clip():
    one, other = of_one_size([b"abc", b"abcdef"])
    assert len(one) == len(other)
    for content, filled in ((b"abc", one), (b"abcdef", other)):
        box = filled.removeprefix(content)
        assert int.from_bytes(box[:4], "big") == len(box)
        assert box[4:8] == b"free"


# Clips


def test_a_clip_is_another_when_anything_it_shows_is():
    own = face().frames(schedule())
    heard = replace(own.schedule, audio=ll.Audio(np.zeros(9, np.int16), 8000))
    clips = [Clip(own, own), Clip(spoilt(own, 0), own), Clip(own, spoilt(own, 0)),
             Clip(replace(own, fps=24), own), Clip(replace(own, model=face("crab").model), own),
             Clip(replace(own, schedule=heard), own)]  # fmt: skip
    assert len({clip.digest for clip in clips}) == len(clips)
    assert Clip(replace(own), own).digest == clips[0].digest


@full
def test_clips_of_a_pair_are_encoded_alike_and_play(tmp_path, monkeypatch):
    monkeypatch.setattr(study_clips, "CLIP_SIDE", 96)
    who = face()
    sound = ll.Audio((np.sin(np.arange(8000 * 0.6) / 3) * 9000).astype(np.int16), 8000)
    own = who.frames(replace(schedule(), audio=sound))
    clips = [Clip(own, own), Clip(who.animate(Method("k", "keyframes"), "x", own), own),
             Clip(spoilt(own, 1), own)]  # fmt: skip
    assert render_clips(clips, tmp_path, workers=1) == 3
    assert render_clips(clips, tmp_path, workers=1) == 0
    told = [probe(clip.path(tmp_path)) for clip in clips]
    assert told[0] == told[1] == told[2]
    streams = told[0]
    assert "h264 (Constrained Baseline)" in streams or "h264 (Baseline)" in streams
    assert "yuv420p" in streams
    assert "aac" in streams
    padded = tmp_path / "padded.mp4"
    padded.write_bytes(of_one_size([clips[0].path(tmp_path).read_bytes(), bytes(10**6)])[0])
    assert probe(padded) == told[0]


def probe(path):
    """Return ffmpeg's description of the streams of a file."""
    from imageio_ffmpeg import get_ffmpeg_exe

    command = [get_ffmpeg_exe(), "-nostdin", "-i", str(path), "-f", "null", "-"]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    given = done.stderr.partition("Output #0")[0]
    told = [
        re.sub(r"\d+ kb/s", "", line.strip()) for line in given.split("\n") if "Stream #" in line
    ]
    assert "rror" not in done.stderr
    return "\n".join(told)


def test_a_missing_encoder_is_named_by_its_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ll.OutputError, match=r"lipsync-lang\[video\]"):
        made(tmp_path)
    assert not (tmp_path / "study/study.json").exists()


@full
def test_processes_render_what_one_does(tmp_path):
    own = face().frames(schedule())
    clips = [Clip(own, own), Clip(spoilt(own, 1), own)]
    told = []
    render_clips(clips, tmp_path / "many", workers=2, told=lambda *numbers: told.append(numbers))
    render_clips(clips, tmp_path / "one", workers=1)
    assert told == [(0, 2), (1, 2), (2, 2)]
    for clip in clips:
        assert clip.path(tmp_path / "many").read_bytes() == clip.path(tmp_path / "one").read_bytes()


# The command


def test_the_command_makes_a_study(tmp_path, cli, drawn):
    script = tmp_path / "script.csv"
    script.write_text("id,text\nhello,Hello Bob.\nmaps,Maps and pies.\n")
    out = tmp_path / "study"
    done = cli(
        "study", "new", script, "-l", "english", "-c", "facefx", "--method", "ours", "--method",
        "keyframes", "--tts", "none", "--workers", "1", "-o", out, "--json",
        "--ask", "Age group: 18-30|31-50",
    )  # fmt: skip
    study = read_study(out / "study.json")
    assert done.code == 0
    assert json.loads(done.out)["study"] == study.study
    assert {pair.line for pair in study.pairs} == {"hello", "maps"}
    assert study.asked == ("age_group",)
    assert "2 pairs, 1 attention check" in done.err
    assert drawn


@pytest.mark.parametrize(("arguments", "told"), [
    (["--method", "ours"], "two methods or more"),
    (["--method", "ours", "--method", "held", "-c", "arkit"], "has no model to film"),
    (["--method", "ours", "--method", "held", "--pairs", "0"], "not a whole number of 1 or more"),
])  # fmt: skip
def test_the_command_refuses_what_makes_no_study(tmp_path, cli, arguments, told):
    if "-c" not in arguments:
        arguments = [*arguments, "-c", "facefx"]
    done = cli(
        "study", "new", "--text", "Hello", "-l", "english", *arguments, "--tts", "none",
        "-o", tmp_path / "study",
    )  # fmt: skip
    assert done.code == 2
    assert told in done.err
    assert not (tmp_path / "study").exists()


def test_parts_of_a_page_are_written_one_by_one(tmp_path, drawn):
    """A page of 60 MB is never in memory as a whole."""
    study = made(tmp_path)
    parts = list(study_page(study.study, PageTexts(), lambda _: [b"left", b"right"]))
    assert len(parts) > 2 * len(study.study.pairs)
    assert Path(study.folder, "page.html").exists()
    assert drawn
