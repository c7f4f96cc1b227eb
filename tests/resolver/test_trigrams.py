"""Trigrams: those that are played, their effect, and no other changes."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from packs_tree import put
from strategies import RATES, any_lines, real

from lipsync_lang import Schedule, resolve
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.splicing import SplicedText
from lipsync_lang.pipeline import kernel
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.tables import RESOLUTION
from lipsync_lang.pipeline.track import lay_track, trigrams_in
from lipsync_lang.pipeline.warp import locate, stitch, warp
from lipsync_lang.resolver import cache
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.resolver.retouch import OpenPair

CURVE = "[[0, 0], [0.2, 0.9], [0.4, 0.9], [0.6, 0.9], [0.8, 0.9], [1, 0]]"
STREET = Schedule(("S", "T", "R", "IY", "T"), np.arange(6) / 10, notation="arpabet")


def character(folder, entries, name="anna"):
    """Write a character of facefx with some trigrams, or with more fields."""
    head = f"kind: character\nformat: 1\nname: {name}\nposeset: facefx\n"
    put(folder, f"characters/{name}.yaml", head + entries)


def trigram(key, pose="FV", **fields):
    stated = "".join(f"{name}: {value}, " for name, value in fields.items())
    return f"  {key}: {{{stated}curves: {{{pose}: {CURVE}}}}}\n"


def bank(folder, name, entries, more=""):
    head = f"kind: bank\nformat: 1\nname: {name}\nposeset: facefx\n{more}"
    put(folder, f"posesets/facefx/banks/{name}.yaml", head + entries)


def performer(folder, name="anna", language="english", **settings):
    return resolve(language, name, paths=folder, cache=False, **settings)


def played(made, schedule):
    """Return the units that a schedule plays, in order, with each trigram twice."""
    origins = made.compiled.origins
    return [origins[row].name for row in made.track(schedule).rows.tolist()]


# Which are played


def test_a_trigram_takes_the_places_of_two_bigrams(tmp_path):
    character(tmp_path, "trigrams:\n" + trigram("s-d-r"))
    made = performer(tmp_path)
    assert played(made, STREET) == ["_-s", "s-d-r", "s-d-r", "r-iy", "iy-d", "d-_"]
    drawn = made.perform(STREET)
    assert drawn["FV"].max() > 0.5 > real().perform(STREET)["FV"].max()
    assert made.report.trigrams == {"s-d-r": "character"}
    assert "1 trigram: s-d-r (character)" in str(made.report)


def test_of_two_that_share_a_bigram_the_first_plays(tmp_path):
    character(tmp_path, "trigrams:\n" + trigram("_-s-d") + trigram("s-d-r") + trigram("d-r-iy"))
    made = performer(tmp_path)
    assert played(made, STREET)[:4] == ["_-s-d", "_-s-d", "d-r-iy", "d-r-iy"]


@given(any_lines())
def test_those_that_play_share_no_bigram_and_leave_no_room_for_another(line):
    around = np.array([line.tables.silence, *line.ids, line.tables.silence])
    begun = trigrams_in(around, line.tables).tolist()
    assert all(after - before > 1 for before, after in pairwise(begun))
    size = len(line.tables.pairs)
    for at, (a, b, c) in enumerate(zip(around, around[1:], around[2:], strict=False)):
        known = (a * size + b) * size + c in line.tables.trigrams
        assert known or at not in begun
        assert not known or {at - 1, at} & {*begun}


def test_the_earlier_layer_wins(tmp_path):
    bank(tmp_path, "shared", "trigrams:\n" + trigram("s-d-r") + trigram("r-ih-d"))
    bank(tmp_path, "own", "trigrams:\n" + trigram("s-d-r"), "language: english\n")
    layers = [performer(tmp_path, "facefx").report.trigrams]
    character(tmp_path, "trigrams:\n" + trigram("s-d-r"))
    layers.append(performer(tmp_path).report.trigrams)
    layers.append(performer(tmp_path, language="german").report.trigrams)
    own = {"r-ih-d": "shared"}
    assert layers == [own | {"s-d-r": layer} for layer in ("language", "character", "character")]


def test_shades_play_that_of_their_parents_and_the_finest_first(tmp_path):
    parents, finer = trigram("r-ih-d"), trigram("r-iy-d")
    character(tmp_path, "trigrams:\n" + parents)
    made = performer(tmp_path)
    assert played(made, STREET)[3:5] == ["r-ih-d"] * 2
    told = made.explain(made.perform(STREET), 0.35)
    assert (told.bigrams[0].pair, told.bigrams[0].drawn_as) == (("r", "iy", "d"), ("r", "ih", "d"))
    character(tmp_path, "trigrams:\n" + parents + finer)
    assert played(performer(tmp_path), STREET)[3:5] == ["r-iy-d"] * 2
    assert played(performer(tmp_path, shades=False), STREET)[3:5] == ["r-ih-d"] * 2


def test_a_trigram_may_tell_a_shade_from_its_parent(tmp_path):
    shades = resolve("english", "rhubarb").report.shades
    assert "ae" not in shades, "no target of this face tells it"
    head = "kind: character\nformat: 1\nname: anna\nposeset: rhubarb\ntrigrams:\n"
    put(tmp_path, "characters/anna.yaml", head + trigram("kg-ae-d", "D"))
    made = performer(tmp_path)
    assert {*made.report.shades} == {*shades, "ae"}
    cat = Schedule(("K", "AE", "T"), [0, 0.1, 0.3, 0.4], notation="arpabet")
    assert played(made, cat)[1:3] == ["kg-ae-d"] * 2


def test_phonemes_of_other_languages_are_left_out(tmp_path):
    bank(tmp_path, "foreign", "trigrams:\n" + trigram("r-yu-d"))
    assert performer(tmp_path, "facefx").report.trigrams == {}
    assert len(performer(tmp_path, "facefx").compiled.tables.trigrams) == 0


def test_bigrams_of_a_style_come_before_neutral_trigrams(tmp_path):
    character(tmp_path, "trigrams:\n" + trigram("s-d-r"))
    made = performer(tmp_path)
    assert made.perform(STREET)["FV"][20:30].max() > 0.5
    bank(tmp_path, "sad", f"bigrams:\n  d-r: {{curves: {{wide: {CURVE}}}}}\n", "style: sad\n")
    made = performer(tmp_path)
    sad = made.perform(STREET, styles={"sad": 1.0})
    assert sad["FV"].max() < 0.2
    assert sad["wide"].max() > 0.5
    half = made.perform(STREET, styles={"sad": 0.5})
    assert 0.2 < half["FV"].max() < made.perform(STREET)["FV"].max()
    told = made.explain(half, 0.25)
    assert [one.style for one in told.bigrams[0].styles] == ["sad"]


# What they show

SLOW = Schedule(STREET.labels, [0, 0.5, 0.75, 1.25, 2.25, 2.5], notation="arpabet")
"""Its frames at 64 a second lie where curves are tabulated, or at every nth such place."""

THIRD = RESOLUTION // 2
"""Steps of a phoneme in a bigram with its boundary in the middle."""


def stitched(made, first, second):
    """Return the maximum of two bigrams over three phonemes as the curves of a trigram."""
    numbers, tables = made.compiled.numbers(shades=True), made.compiled.tables
    pairs = (first, second)
    one, two = (tables.curves[tables.pairs[numbers[a], numbers[b]]] for a, b in pairs)
    middle = np.maximum(one[THIRD:], two[: THIRD + 1])
    whole = np.concatenate((one[:THIRD], middle, two[THIRD + 1 :])).clip(0, 1)
    times = np.linspace(0, 1, len(whole)).tolist()
    curves = {
        pose: [[time, value] for time, value in zip(times, line.tolist(), strict=True)]
        for pose, line in zip(made.poses, whole.T, strict=True)
    }
    key = "-".join((*first, second[1]))
    return f"trigrams:\n  {key}: {{interpolation: linear, curves: {curves}}}\n".replace("'", "")


@pytest.mark.parametrize("key", ["s-d-r", "_-s-d", "r-iy-d", "iy-d-_"])
def test_a_trigram_that_is_the_stitch_of_its_bigrams_changes_nothing(tmp_path, key):
    one, two, three = key.split("-")
    character(tmp_path, stitched(real(), (one, two), (two, three)))
    made, settings = performer(tmp_path), {"sound_reach": 1e6}
    assert key in played(made, SLOW)
    before = real().with_motion(settings).perform(SLOW, 64).weights
    after = made.with_motion(settings).perform(SLOW, 64).weights
    assert np.abs(after - before).max() <= 1e-6


@pytest.mark.parametrize("motion", [{}, {"warp": "linear"}, {"stitch": "crossfade"}], ids=str)
@given(cut=st.tuples(st.floats(0.1, 0.45), st.floats(0.55, 0.9)), seed=st.integers(0, 99))
def test_its_boundaries_lie_on_the_spoken_ones(cut, seed, motion):
    """Over normalised time a curve that tells the time, and flat neighbours, show where one is."""
    tables, lengths = clock(cut), np.random.default_rng(seed).uniform(0.05, 0.25, 3)
    times = np.concatenate(([0.0], np.cumsum(lengths)))
    track = lay_track(np.arange(1, 4), times, np.arange(3), tables, Motion(**motion))
    assert track.trigrams.tolist() == [1]
    asked = np.concatenate([np.linspace(*ends, 20, endpoint=False) for ends in pairwise(times)])
    place = locate(track, asked)
    shown = stitch(*warp(tables.neutral, track, place), place, motion.get("stitch", "max"))[0]
    wanted = np.interp(asked, times, [0, *cut, 1])
    middle = (asked >= times[1]) & (asked < times[2])
    if "stitch" in motion:  # over its ends the neighbours fade it in and out
        shown, wanted = shown[middle], wanted[middle]
    assert np.abs(shown - wanted).max() <= 1e-5


def clock(cut):
    """Tables of silence and three phonemes, whose trigram rises from 0 to 1; bigrams rest."""
    first, second = cut
    at = np.linspace(0, 1, RESOLUTION + 1)
    rising = np.stack((0 * at, at * second, first + (1 - first) * at)).astype(np.float32)
    return replace(
        real().compiled.tables,
        curves=np.ascontiguousarray(rising[:, :, None]),
        boundary=np.array([0.5, first / second, (second - first) / (1 - first)]),
        free=np.zeros(3, bool),
        pairs=np.zeros((4, 4), np.intp),
        trigrams=np.array([(1 * 4 + 2) * 4 + 3]),
        trigram_rows=np.array([[1, 2]]),
    )


def test_a_trigram_waives_the_contacts_of_its_three_phonemes(tmp_path):
    up = Schedule(("AA", "P", "AA"), [0, 0.2, 0.3, 0.5], notation="arpabet")
    character(tmp_path, "trigrams:\n" + trigram("aa-bmp-aa", "open"))
    held = performer(tmp_path)
    (warning,) = held.report.warnings
    for told in ("characters/anna.yaml:6:3", "W306", "aa-bmp-aa brings PBM to 0.00 at bmp"):
        assert told in warning
    assert held.perform(up)["PBM"].max() >= 0.7
    character(tmp_path, "trigrams:\n" + trigram("aa-bmp-aa", "open", contact="free"))
    free = performer(tmp_path)
    assert free.report.warnings == ()
    assert free.track(up).waived.tolist() == [False, True, True, True, False]
    assert free.perform(up)["PBM"].max() < 0.01


def test_explain_names_the_trigram_its_layer_its_place_and_the_time_in_it(tmp_path):
    entries = "trigrams:\n" + trigram("s-d-r", word="street", boundaries="[0.2, 0.6]")
    character(tmp_path, entries)
    drawn = performer(tmp_path).perform(STREET)
    for seconds, within, neighbours in ((0.05, 0.1, 1), (0.15, 0.4, 0), (0.25, 0.8, 1)):
        told = drawn.explain(seconds)
        (found,) = [one for one in told.bigrams if one.unit == "trigram"]
        assert len(told.bigrams) == 1 + neighbours
        assert (found.pair, found.layer, found.word) == (("s", "d", "r"), "character", "street")
        assert found.position == pytest.approx(within, abs=0.05)
        (place,) = found.places
        assert place.endswith("characters/anna.yaml:6:3")
        assert "  trigram s-d-r at " in str(told)
        shown = next(pose for pose in told.poses if pose.pose == "FV")
        assert "s-d-r gives" in shown.stages[0].why
        assert max(shown.bigrams) == pytest.approx(shown.stages[0].weight, abs=1e-3)


# Ways to the same frames

BOTH = "trigrams:\n" + "".join(map(trigram, ("_-s-d", "d-r-iy", "iy-d-_", "d-iy-d", "iy-d-iy")))


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawn")
    character(folder, BOTH)
    return performer(folder)


SPOKEN = st.lists(st.sampled_from(["S", "T", "R", "IY", "T", "IY", "_"]), min_size=1, max_size=14)


def assert_streamed(made, schedule, fps=60):
    """Check that a stream that is fed label by label has the frames of the whole schedule."""
    stream, found = made.stream(fps, notation="arpabet", stress=False), []
    for label, (start, end) in zip(schedule.labels, pairwise(schedule.times.tolist()), strict=True):
        stream.feed(label, start, end)
        found.append(stream.frames().weights)
    stream.finish()
    found.append(stream.frames().weights)
    assert np.abs(np.concatenate(found) - made.perform(schedule, fps).weights).max() <= 1e-6


@given(labels=SPOKEN, fps=RATES)
def test_a_stream_gives_the_frames_of_the_whole(drawn, labels, fps):
    schedule = Schedule(tuple(labels), np.arange(len(labels) + 1) / 8, notation="arpabet")
    assume({*labels} != {"_"})  # a stream has no frame of nothing but silence
    assert_streamed(drawn, schedule, fps)


def test_an_endless_row_of_overlapping_trigrams_needs_no_more_memory(drawn):
    stream, labels = drawn.stream(60, notation="arpabet", stress=False), ("T", "IY") * 300
    held, found = 0, []
    for number, label in enumerate(labels):
        stream.feed(label, number / 10, (number + 1) / 10)
        found.append(stream.frames().weights)
        held = max(held, stream.held)
    stream.finish()
    found.append(stream.frames().weights)
    whole = drawn.perform(Schedule(labels, np.arange(601) / 10, notation="arpabet"), 60)
    assert np.abs(np.concatenate(found) - whole.weights).max() <= 1e-6
    assert held < 120


def test_a_frame_waits_for_the_third_sound_only_where_a_trigram_may_begin(drawn):
    def final(*labels):
        stream = drawn.stream(60, notation="arpabet", stress=False)
        for number, label in enumerate(("S", "EH", *labels)):
            stream.feed(label, number, number + 1)
        return stream.final_until

    assert final("IY", "S") == final("T", "S") == final("S", "S")
    assert final("T", "IY") == pytest.approx(final("T", "S") - 1, abs=0.02)
    assert final("T", "IY", "S") == pytest.approx(final("T", "S", "S"))
    assert final("T", "IY", "T") == final("T", "EH", "T"), "d-iy-d leaves no room for iy-d-iy"


def test_silence_that_is_not_there_begins_no_trigram(tmp_path):
    """A window of a stream begins in the middle of the sounds, and silence is put before it."""
    character(tmp_path, "trigrams:\n" + trigram("_-s-d", "PBM") + trigram("s-d-r"))
    labels = ("IY", "S", "T", "R") * 6
    times = np.arange(len(labels) + 1.0)
    assert_streamed(performer(tmp_path), Schedule(labels, times, notation="arpabet"))


@pytest.mark.parametrize("last", ["F", "S"])
def test_a_contact_waits_for_the_sound_that_may_waive_it(tmp_path, last):
    character(tmp_path, "trigrams:\n" + trigram("bmp-aa-f", "open", contact="free"))
    made = performer(tmp_path, motion={"anticipate": 0, "softness": 0, "speed_limit": 5000})
    times = [0, 0.3, 0.33, 0.605, 0.9]
    for fps in (24, 1000):
        assert_streamed(made, Schedule(("AA", "P", "AA", last), times, notation="arpabet"), fps)


def test_many_schedules_at_once_are_what_each_is_alone(drawn):
    schedules = [STREET, SLOW, Schedule(("T", "IY", "T"), [0, 0.1, 0.2, 0.3], notation="arpabet")]
    for motion in (None, {"warp": "linear"}):
        made = drawn.with_motion(motion)
        for one, alone in zip(made.perform_many(schedules), schedules, strict=True):
            assert np.array_equal(one.weights, made.perform(alone).weights)


def test_the_compiled_kernel_and_numpy_agree(drawn, monkeypatch):
    for motion in (None, {"warp": "linear"}):
        performance = drawn.with_motion(motion).performance(STREET, 60)
        weights = performance.weights()
        with monkeypatch.context() as patch:
            patch.setattr(kernel, "compiled", None)
            assert np.abs(weights - performance.weights()).max() <= 1e-11


def test_a_pair_with_trigrams_is_the_same_from_the_cache(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    character(tmp_path, BOTH)
    first = resolve("english", "anna", paths=tmp_path)
    again = cache.load("english", "anna", [tmp_path])
    assert again is not None
    assert again.origins == first.compiled.origins
    assert again.report == first.report
    for name in ("trigrams", "trigram_rows", "curves", "boundary"):
        mine, its = getattr(again.tables, name), getattr(first.compiled.tables, name)
        assert mine.dtype == its.dtype
        assert np.array_equal(mine, its)
    character(tmp_path, "trigrams:\n" + trigram("s-d-r"))
    assert cache.load("english", "anna", [tmp_path]) is None


# Editing


def test_a_bigram_edited_in_place_leaves_trigrams_as_compiling_anew_does(tmp_path):
    character(tmp_path, BOTH + "bigrams: {}\n")
    bank(tmp_path, "sad", "bigrams: {}\n", "style: sad\n")
    library = Library([tmp_path], project=None)
    pair = OpenPair.open(library, "english", "anna")
    texts = {}
    for path in (tmp_path / "characters/anna.yaml", tmp_path / "posesets/facefx/banks/sad.yaml"):
        texts[path] = SplicedText.read(path, path.read_bytes())
    curves = {"curves": {"open": [[0, 0], [0.5, 0.3], [1, 0]]}}
    for path, keys in zip(list(texts), (("ae-kg", "d-r"), ("iy-d",)), strict=True):
        for key in keys:
            texts[path] = texts[path].changed([(("bigrams", key), curves)])
        pair = pair.retouched(texts.values())
        unsaved = {one: other.content for one, other in texts.items()}
        anew = compile_pair(
            Library([tmp_path], project=None, unsaved=unsaved, earlier=library), "english", "anna"
        )
        mine, its = pair.compiled, anew
        assert mine.tables.trigrams.tolist() == its.tables.trigrams.tolist()
        assert mine.tables.trigram_rows.tolist() == its.tables.trigram_rows.tolist()
        assert np.array_equal(mine.tables.curves, its.tables.curves)
        for one, other in zip(mine.tables.styles, its.tables.styles, strict=True):
            assert all(map(np.array_equal, one, other))
        assert [one._replace(places=()) for one in mine.origins] == [
            one._replace(places=()) for one in its.origins
        ]
    content = texts[tmp_path / "characters/anna.yaml"].content.decode()
    assert BOTH in content


def test_a_trigram_that_changed_is_compiled_anew(tmp_path):
    character(tmp_path, BOTH)
    path = tmp_path / "characters/anna.yaml"
    pair = OpenPair.open(Library([tmp_path], project=None), "english", "anna")
    changed = path.read_text("utf-8").replace("0.9", "0.8")
    assert pair.retouched([SplicedText.read(path, changed.encode())]) is None
