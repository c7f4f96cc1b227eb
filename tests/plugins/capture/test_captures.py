"""Captures: files of motion become lines of signals, and faulty ones are listed."""

import numpy as np
import pytest

import lipsync_lang as ll
from lipsync_lang.animations.animation_readers import ANIMATION_READERS
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.plugins.capture.capture_files import find_captures
from lipsync_lang.plugins.capture.capture_reading import load_readout, read_captures

assert ANIMATION_READERS, "a sweep over nothing passes"

SPOKEN = ll.Schedule(
    ("_", "M", "AA", "P", "IY", "_"), [0, 0.2, 0.3, 0.5, 0.6, 0.8, 1.0], notation="arpabet"
)
READ_OUT = """\
kind: readout
format: 1
measures:
  aperture: {up: 1, low: -1}
  protrusion: {front: -2}
lost: 0
"""
COILS = "time_s,up,low,front\n0,3,1,1\n0.01,4,1,1.5\n0.02,5,0,2\n0.03,6,1,\n"


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def take(folder, name="take", suffix=".csv", performer=None, fps=60):
    """Save a performance with its timings beside it."""
    performer = performer or ll.resolve("english", "facefx")
    path = folder / f"{name}{suffix}"
    path.parent.mkdir(parents=True, exist_ok=True)
    animation = performer.perform(SPOKEN, fps=fps)
    animation.save(path)
    SPOKEN.save(path.with_suffix(".TextGrid"))
    return animation


def only(captures):
    assert not captures.set_aside
    (line,) = captures.lines
    return line


def why(captures):
    assert not captures.lines
    (aside,) = captures.set_aside
    return aside.why


@pytest.mark.parametrize("suffix", sorted(ANIMATION_READERS.suffixes()))
def test_curves_are_read_back_with_their_timings(performer, tmp_path, suffix):
    animation = take(tmp_path, suffix=suffix)
    line = only(read_captures(performer, tmp_path))
    assert line.name == "take"
    assert line.schedule.labels == SPOKEN.labels
    assert line.signals == performer.poses
    assert not line.free
    np.testing.assert_allclose(line.times, animation.times, atol=1e-5)
    np.testing.assert_allclose(line.values, animation.weights, atol=1e-4)
    np.testing.assert_array_equal(line.gains, np.eye(len(performer.poses)))


def test_our_json_needs_no_timings_and_timings_beside_it_win(performer, tmp_path):
    take(tmp_path, suffix=".json")
    (tmp_path / "take.TextGrid").unlink()
    assert only(read_captures(performer, tmp_path)).schedule.labels == SPOKEN.labels
    SPOKEN.stretched(1.25).save(tmp_path / "take.TextGrid")
    assert only(read_captures(performer, tmp_path)).schedule.end == pytest.approx(1.25)


def test_a_take_of_live_link_face_is_poses_of_a_face_with_its_shapes(tmp_path):
    performer = ll.resolve("english", "arkit")
    animation = performer.perform(SPOKEN, fps=60)
    animation.save(tmp_path / "take.csv", "live-link-face")
    SPOKEN.save(tmp_path / "take.TextGrid")
    line = only(read_captures(performer, tmp_path / "take.csv"))
    assert set(line.signals) == set(performer.poses)
    jaw = line.values[:, line.signals.index("jawOpen")]
    assert jaw.max() == pytest.approx(animation["jawOpen"].max(), abs=1e-3)


def test_rig_channels_come_with_the_gains_of_the_rig(tmp_path):
    (tmp_path / "characters").mkdir()
    text = "kind: character\nformat: 1\nname: max\nposeset: facefx\nrig: facefx-to-arkit\n"
    (tmp_path / "characters/max.yaml").write_text(text, "utf-8")
    rigged = ll.resolve("english", "max", paths=[tmp_path])
    animation = rigged.perform(SPOKEN)
    channels = rigged.rigged(animation)
    channels.save(tmp_path / "take.csv")
    SPOKEN.save(tmp_path / "take.TextGrid")
    line = only(read_captures(rigged, tmp_path / "take.csv"))
    assert set(line.signals) <= set(channels.poses)
    assert len(line.signals) == (line.gains.any(axis=1)).sum() > 10
    at = line.signals.index("jawOpen")
    sums = animation.weights @ line.gains[at]
    np.testing.assert_allclose(line.values[:, at], np.clip(sums, 0, 1), atol=0.05)


def test_missing_columns_are_left_out_and_named_never_taken_for_rest(performer, tmp_path):
    take(tmp_path)
    table = (tmp_path / "take.csv").read_text().splitlines()
    head = table[0].split(",")
    kept = [at for at, name in enumerate(head) if name not in {"open", "W"}]
    rows = (",".join(row.split(",")[at] for at in kept) for row in table)
    (tmp_path / "take.csv").write_text("\n".join(rows))
    line = only(read_captures(performer, tmp_path))
    assert not {"open", "W"} & set(line.signals)
    assert line.values.shape[1] == line.gains.shape[0] == len(performer.poses) - 2
    assert any("has no column for open, W; these are not fitted" in told for told in line.remarks)


def test_percent_are_told(performer, tmp_path):
    animation = take(tmp_path)
    rows = [",".join(("time_s", *animation.poses))]
    rows += [
        ",".join(f"{v:.4f}" for v in (t, *(100 * w)))
        for t, w in zip(animation.times, animation.weights, strict=True)
    ]
    (tmp_path / "take.csv").write_text("\n".join(rows))
    line = only(read_captures(performer, tmp_path))
    assert line.values.max() <= 1
    assert any("percent" in told for told in line.remarks)


# Which files belong together


def test_timings_are_found_by_the_name_up_to_its_first_dot(performer, tmp_path):
    take(tmp_path)
    (tmp_path / "take.csv").rename(tmp_path / "take.face.csv")
    assert only(read_captures(performer, tmp_path)).name == "take"
    take(tmp_path)
    (tmp_path / "take.csv").rename(tmp_path / "take.other.csv")
    (tmp_path / "take.TextGrid").rename(tmp_path / "take.other.TextGrid")
    captures = read_captures(performer, tmp_path)
    assert [line.name for line in captures.lines] == ["take.other"], "two captures share no timings"
    (aside,) = captures.set_aside
    assert aside.line == "take.face"
    assert "no timings" in aside.why


def test_the_folder_below_names_the_speaker_and_a_pattern_does(performer, tmp_path):
    take(tmp_path, "anna/one")
    take(tmp_path, "berta/two")
    lines = read_captures(performer, tmp_path).lines
    assert [(line.name, line.speaker) for line in lines] == [
        ("anna/one", "anna"), ("berta/two", "berta"),
    ]  # fmt: skip
    lines = read_captures(performer, tmp_path, speaker="*/{speaker}").lines
    assert [line.speaker for line in lines] == ["one", "two"]
    take(tmp_path, "anna/clara_3")
    lines = read_captures(performer, tmp_path, speaker="{speaker}_*").lines
    assert {line.name: line.speaker for line in lines} == {
        "anna/clara_3": "clara", "anna/one": "", "berta/two": "",
    }  # fmt: skip
    with pytest.raises(ll.LipsyncError, match=r"a pattern has `\{speaker\}` once"):
        read_captures(performer, tmp_path, speaker="anna")


def test_a_list_names_timings_speakers_and_starts(performer, tmp_path):
    take(tmp_path, "a/one")
    (tmp_path / "a/one.TextGrid").rename(tmp_path / "timed.TextGrid")
    (tmp_path / "lines.csv").write_text(
        "capture;timings;speaker;start;fps\na/one.csv;timed.TextGrid;anna;0.25;60\n"
        "a/two.csv;;;;\n../x.csv;;;;\na/one.csv;;;soon;\n"
    )
    captures = read_captures(performer, tmp_path)
    (line,) = captures.lines
    plain = performer.perform(SPOKEN, fps=60)
    assert (line.name, line.speaker) == ("a/one", "anna")
    assert line.times[0] == pytest.approx(plain.times[0] + 0.25)
    told = {aside.line: aside.why for aside in captures.set_aside}
    assert "lines.csv:3: there is no file 'a/two.csv'" in told["a/two.csv"]
    assert "is outside the folder of the list" in told["../x.csv"]
    assert "`start` is 'soon'" in told["a/one.csv"]


def test_a_list_with_an_unknown_column_is_refused(tmp_path):
    (tmp_path / "lines.csv").write_text("capture,timing\n")
    with pytest.raises(ll.LipsyncError, match="unknown column 'timing'; did you mean 'timings'"):
        find_captures(tmp_path / "lines.csv")


def test_a_stated_rate_that_the_times_deny_sets_a_capture_aside(performer, tmp_path):
    take(tmp_path)
    (tmp_path / "lines.csv").write_text("capture,fps\ntake.csv,30\n")
    told = why(read_captures(performer, tmp_path))
    assert "its times have 60 frames per second, but the list states 30" in told


def test_text_and_sound_are_aligned(performer, tmp_path):
    spoken = ll.speak("Please buy five maps", "english")
    animation = performer.perform(spoken)
    animation.save(tmp_path / "take.csv")
    animation.save(tmp_path / "take.wav")
    (tmp_path / "take.txt").write_text("Please buy five maps")
    line = only(read_captures(performer, tmp_path))
    assert [word.text for word in line.schedule.words] == ["Please", "buy", "five", "maps"]
    assert line.schedule.audio is None, "its loudness is the recording's, not the bank's"
    (tmp_path / "take.wav").unlink()
    assert "a text, but no sound" in why(read_captures(performer, tmp_path))


def test_timed_words_are_filled(performer, tmp_path):
    take(tmp_path)
    (tmp_path / "take.TextGrid").unlink()
    (tmp_path / "take.tsv").write_text("word\tstart\tend\nmaps\t0.2\t0.8\n")
    assert only(read_captures(performer, tmp_path)).schedule.words[0].text == "maps"


# Timings


def timed(tmp_path, rows):
    (tmp_path / "take.TextGrid").unlink(missing_ok=True)
    (tmp_path / "take.tsv").write_text("".join(f"{a}\t{b}\t{label}\n" for label, a, b in rows))


def test_a_few_unknown_labels_are_silence_and_named_many_are_refused(performer, tmp_path):
    take(tmp_path)
    sounds = [("M" if n % 2 else "AA", n / 10, n / 10 + 0.1) for n in range(12)]
    timed(tmp_path, [*sounds, ("?!", 1.2, 1.3)])
    line = only(read_captures(performer, tmp_path, notation="arpabet"))
    assert line.schedule.labels[-1] == "_"
    assert any("labels unknown to english, read as silence: ?!" in one for one in line.remarks)
    timed(tmp_path, [*sounds[:4], ("?!", 0.4, 0.5)])
    told = why(read_captures(performer, tmp_path, notation="arpabet"))
    assert "1 of 5 labels are unknown to english: ?!" in told


def test_silences_of_a_read_out_may_have_no_length(performer, tmp_path):
    take(tmp_path)
    timed(tmp_path, [("XX#", 0, 0), ("M", 0, 0.1), ("AA", 0.1, 0.3), ("XX#", 0.3, 0.9)])
    assert "list the silent ones in a read-out" in why(read_captures(performer, tmp_path))
    (tmp_path / "readout.yaml").write_text(READ_OUT + 'silences: ["XX#"]\n')
    line = only(read_captures(performer, tmp_path))
    assert line.schedule.labels == ("M", "AA", "_")


def test_a_last_sound_that_runs_into_silence_is_cut(performer, tmp_path):
    take(tmp_path)
    timed(tmp_path, [("M", 0, 0.1), ("AA", 0.1, 1.9)])
    line = only(read_captures(performer, tmp_path))
    assert line.schedule.labels == ("M", "AA", "_")
    np.testing.assert_allclose(line.schedule.times, [0, 0.1, 0.2, 1.9])
    assert any("its last sound, 'AA', lasts 1.80 s" in told for told in line.remarks)


def test_timings_of_silence_alone_are_set_aside(performer, tmp_path):
    take(tmp_path)
    timed(tmp_path, [("sil", 0, 180)])
    assert "has only silence" in why(read_captures(performer, tmp_path))


# Sensors


@pytest.fixture
def coils(tmp_path):
    (tmp_path / "readout.yaml").write_text(READ_OUT)
    (tmp_path / "take.ema.csv").write_text(COILS)
    SPOKEN.save(tmp_path / "take.TextGrid")
    return tmp_path


def test_sensors_are_read_as_measures_and_lost_ones_as_nan(performer, coils):
    line = only(read_captures(performer, coils))
    assert line.name == "take"
    assert line.signals == ("aperture", "protrusion")
    assert line.free
    np.testing.assert_array_equal(line.values[:, 0], [2, 3, np.nan, 5])
    np.testing.assert_array_equal(line.values[:, 1], [-2, -3, -4, np.nan])
    stated = performer.compiled.measures["aperture"]
    assert line.gains[0].tolist() == [stated.get(pose, 0.0) for pose in performer.poses]


def test_the_read_out_of_a_folder_holds_below_and_a_stated_one_wins(performer, coils):
    (coils / "deep/er").mkdir(parents=True)
    (coils / "take.ema.csv").rename(coils / "deep/er/take.csv")
    (coils / "take.TextGrid").rename(coils / "deep/er/take.TextGrid")
    assert len(only(read_captures(performer, coils)).signals) == 2
    other = coils / "other.yaml"
    other.write_text("kind: readout\nformat: 1\nname: other\nmeasures: {aperture: {up: 1}}\n")
    assert only(read_captures(performer, coils, readout=other)).signals == ("aperture",)
    told = why(read_captures(performer, coils / "deep"))
    assert "for a table of sensors, give a read-out" in told, "none is looked for above the folder"


def test_measures_without_a_column_or_a_pose_set_are_left_out_and_named(performer, coils):
    text = READ_OUT + "  # none\n"
    (coils / "readout.yaml").write_text(
        text.replace("protrusion: {front", "protrusion: {gone").replace("lost: 0", "")
        + "title: x\n"
    )
    line = only(read_captures(performer, coils))
    assert line.signals == ("aperture",)
    assert any("has no column 'gone', so measure 'protrusion'" in told for told in line.remarks)
    (coils / "readout.yaml").write_text(READ_OUT.replace("protrusion", "warmth"))
    line = only(read_captures(performer, coils))
    assert "facefx has no measure warmth; these are left out" in line.remarks
    (coils / "readout.yaml").write_text("kind: readout\nformat: 1\nmeasures: {warmth: {up: 1}}\n")
    assert "its read-out has warmth" in why(read_captures(performer, coils))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("kind: readout", "kind: bank", "a pack of kind 'bank' in the place of kind 'readout'"),
        ("aperture: {up: 1, low: -1}", "aperture: {}", "must have at least 1 items"),
        ("up: 1", "up: much", "`up` must be a number"),
        ("lost: 0", "lots: 0", "did you mean 'lost'"),
    ],
)
def test_an_unsound_read_out_is_told_with_its_place(tmp_path, old, new, told):
    path = tmp_path / "readout.yaml"
    path.write_text(READ_OUT.replace(old, new))
    with pytest.raises(PackFaults, match=told):
        load_readout(path)


# Faulty files


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "is empty"),
        ("time_s,up\n", "has only 0 samples"),
        ("time_s,up,low\n0,1,1\n0,2,2\n", "its time does not rise"),
        ("time_s,up,low\n0,1,1\n0.1,x,2\n", "'x' is not a number"),
        ("time_s,up,low\n,1,1\n0.1,1,2\n", "a time is not a number"),
        ("time_s,up\n0,1\n0.1,2\n", "has no column"),
        ("time_s,up,low\n0,1,1\n0.1,1e200,2\n", "sample 1: a value is beyond 1e+09"),
        ("up,low\n1,1\n2,2\n", "its first column is 'up', not a time"),
    ],
)
def test_faulty_tables_of_sensors_are_set_aside(performer, coils, content, told):
    (coils / "take.ema.csv").write_text(content)
    assert told in why(read_captures(performer, coils))


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("take.csv", b"time_s,open\n0,0\n0.1,nan\n", "a value is not a number"),
        ("take.csv", b"time_s,open\n0,0\n0.1,-1e200\n", "frame 1: a value is beyond 1e+09"),
        ("take.csv", b"time_s,brow\n0,0\n0.1,0.2\n", "has nothing of facefx"),
        ("take.csv", b"Timecode,BlendshapeCount,JawOpen\n00:00:00:00.0,61,0\n", "whole take"),
        ("take.glb", b"glTF", "take.glb"),
        ("take.json", b"{}", "not an animation of this program"),
    ],
)
def test_faulty_captures_are_set_aside_and_the_others_read(
    performer, tmp_path, name, content, told
):
    take(tmp_path, "good")
    (tmp_path / name).write_bytes(content)
    SPOKEN.save(tmp_path / "take.TextGrid")
    captures = read_captures(performer, tmp_path)
    assert [line.name for line in captures.lines] == ["good"]
    (aside,) = captures.set_aside
    assert aside.line == "take"
    assert told in aside.why
    assert ("give a read-out" in aside.why) == content.startswith(b"time_s")


def test_missing_paths_and_empty_folders_are_told(performer, tmp_path):
    with pytest.raises(ll.LipsyncError, match="no such file or folder"):
        read_captures(performer, tmp_path / "none")
    with pytest.raises(ll.LipsyncError, match="no captures in"):
        read_captures(performer, tmp_path)


def test_progress_counts_every_capture(performer, tmp_path):
    take(tmp_path, "a")
    take(tmp_path, "b")
    seen = []
    read_captures(performer, tmp_path, progress=lambda *done: seen.append(done))
    assert seen == [(1, 2), (2, 2)]


# Real ones


def test_recordings_of_real_mouths_are_read_with_all_their_measures(root, data):
    german = ll.resolve("german", "facefx")
    captures = read_captures(
        german,
        data / "articulography",
        readout=root / "benchmarks/articulography.yaml",
        speaker="{speaker}_*",
    )
    assert not captures.set_aside
    assert [line.speaker for line in captures.lines] == ["dfg91", "dfgspp", "dfgspp"]
    for line in captures.lines:
        assert line.signals == ("aperture", "protrusion", "tongue_tip")
        assert np.isfinite(line.values).mean() > 0.9
        assert not line.schedule.remarks or "its last sound" in line.schedule.remarks[0]
