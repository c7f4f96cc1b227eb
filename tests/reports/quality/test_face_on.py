"""The comparison with films: figures of lips whose answer is known."""

import gzip
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import lipsync_lang as ll

TIMES = np.arange(0, 4, 1 / 30)
SAID = "DH AH K AE T S AE T AA N DH AH M AE T B AA D IY EH L S M EY D K IY P M AH N IY"
LINE = ll.Schedule(("_", "m", "a", "m", "_"), (0, 0.45, 0.55, 1.2, 1.3, 4))
"""The first /m/ has shut lips (see `lips`), the second has not."""


@pytest.fixture
def face_on(root, monkeypatch):
    monkeypatch.syspath_prepend(root / "benchmarks")
    import face_on as benchmark

    yield benchmark
    sys.modules.pop("face_on")


@pytest.fixture
def run(face_on, monkeypatch):
    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["face_on.py", *map(str, arguments)])
        face_on.main()

    return run


def lips(late=0.0, gain=1.0):
    """Lips that shut every half second and widen every third of a second."""
    at = TIMES - late
    aperture = 1 + np.cos(4 * np.pi * (at - 0.25))
    return np.column_stack([TIMES, gain * aperture, gain * np.sin(6 * np.pi * at)])


def judged(face_on, ours, theirs, ahead=0.0):
    ids, bounds = np.array([0, 1, 2, 1, 0]), np.array(LINE.times)
    names = SimpleNamespace(phonemes=("_", "bmp", "aa"))
    head = SimpleNamespace(
        performer=SimpleNamespace(compiled=names), sounds=lambda _: (ids, bounds)
    )
    return face_on.judge(head, [(LINE, theirs)], ahead, [ours])


def test_equal_lips_agree(face_on):
    found, film, sounds = judged(face_on, lips(), lips())
    for name in ("aperture r", "width r", "aperture range", "width range"):
        assert found[name] == pytest.approx(1)
    assert found["lag ms"] == pytest.approx(0, abs=1e-9)
    assert found["shut %"] == film["shut %"] == 50
    assert set(sounds) == {"bmp", "aa"}
    np.testing.assert_allclose(sounds["bmp"][0][0], sounds["bmp"][0][1])


def test_late_and_smaller_lips_are_told(face_on):
    found, *_ = judged(face_on, lips(late=0.06, gain=0.5), lips())
    assert found["lag ms"] == pytest.approx(60, abs=5)
    assert found["aperture range"] == pytest.approx(0.5, abs=0.02)


def test_lips_are_compared_where_the_film_is_ahead(face_on):
    film = lips(late=-0.06)
    found, *_ = judged(face_on, lips(), film, ahead=0.06)
    assert found["aperture r"] == pytest.approx(1, abs=0.01)
    assert judged(face_on, lips(), film)[0]["aperture r"] < 0.9


def test_lips_that_never_move_are_like_none(face_on):
    still = lips(gain=0.0)
    assert judged(face_on, still, lips())[0]["aperture r"] == 0


def test_frames_without_a_face_do_not_count(face_on):
    film = lips()
    film[20:26, 1:] = np.nan
    found, *_ = judged(face_on, lips(), film)
    assert found["aperture r"] == pytest.approx(1)
    assert np.isfinite(list(found.values())).all()


def clips(head, ahead):
    """Return a clip whose lips are those of the head, so many seconds early."""
    labels = SAID.split()
    times = 0.2 + 0.11 * np.arange(len(labels) + 1)
    schedule = ll.Schedule(("_", *labels, "_"), [0, *times, times[-1] + 0.3])
    shown = head.lips(head.performer.perform(schedule, 100))
    seconds = np.arange(0, schedule.times[-1], 1 / 25)
    lips = [np.interp(seconds + ahead, shown[:, 0], one) for one in shown.T[1:]]
    return [(schedule, np.column_stack([seconds, *lips]))]


def test_the_lips_of_a_head_are_like_themselves_however_early(face_on):
    head = face_on.Head.of("facefx", "english")
    leads = [face_on.lead(head, clips(head, ahead)) for ahead in (0.0, 0.08)]
    assert leads[1] - leads[0] == pytest.approx(0.08, abs=0.04)  # a frame of the film
    figures, film, sounds = face_on.judge(head, clips(head, 0.05), 0.05)
    assert figures["aperture r"] > 0.999
    assert figures["aperture range"] == pytest.approx(1, abs=0.01)
    assert figures["width 5 %"] == pytest.approx(film["width 5 %"], abs=0.01)
    for number, measure in enumerate(face_on.MEASURES):
        heading, *rows = face_on.errors({"one": sounds, "same": sounds}, number)
        assert heading == [measure, "times", "film", "one", "same"]
        assert rows
        assert {row[0] for row in rows} <= set(head.performer.compiled.phonemes)
        assert all(int(row[1]) >= face_on.LEAST_TIMES for row in rows)
        assert all(abs(float(row[3])) < 0.03 for row in rows)


def test_texts_with_tracked_lips_and_films_with_a_text_are_read(face_on, tmp_path):
    (tmp_path / "ann_texts.tsv").write_text("clip\ttext\none\tbin red\n")
    with gzip.open(tmp_path / "ann_lips.tsv.gz", "wt") as stream:
        stream.write(
            "clip\tsecond\tinner_gap\twidth\none\t0\t1\t4\none\t0.04\t\t5\none\t0.08\t2\t3\n"
        )
    (tmp_path / "ann").mkdir()
    for name in ("ann/one.mpg", "own.mp4", "mute.mp4"):
        (tmp_path / name).touch()
    (tmp_path / "own.txt").write_text("hello\n")
    found = face_on.filmed(tmp_path)
    assert set(found) == {"one", "own"}
    one, own = found["one"], found["own"]
    assert one.picture == tmp_path / "ann" / "one.mpg"
    np.testing.assert_allclose(one.lips, [[0, 0.25, 0], [0.04, np.nan, 0.25], [0.08, 0.5, -0.25]])
    assert own == ("hello", tmp_path / "own.mp4", None, tmp_path / "own.mp4")


def test_a_drawn_head_is_measured_as_its_film_is_tracked(face_on, monkeypatch):
    """Lips of another scale, late by the sound's start, come back in widths of the mouth."""
    seen = []
    animation = ll.resolve("english", "facefx").perform(LINE, 30)
    head = face_on.Head(SimpleNamespace(character="a", rigged=lambda one: one), None, None)
    head = head._replace(perform=lambda _, fps: seen.append(fps) or animation)
    monkeypatch.setattr(face_on, "film", lambda *_, **__: None)
    monkeypatch.setattr(face_on, "staged", lambda _: SimpleNamespace(sound=0.4))
    wide = np.add(lips(), (0.4, 0, 4))
    monkeypatch.setattr(face_on, "tracked", lambda _, __, start: wide - (start, 0, 0))
    (found,) = face_on.rendered(head, [(LINE, lips())], "python")
    assert seen == [pytest.approx(30)]
    middle = np.median(wide[:, 2])
    np.testing.assert_allclose(found[:, 0], TIMES, atol=1e-9)
    np.testing.assert_allclose(found[:, 1:], wide[:, 1:] / middle - (0, 1))


def test_the_tables_have_a_column_for_each_head(face_on, run, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(face_on, "clips_of", lambda _: [(LINE, lips())])
    monkeypatch.setattr(face_on, "LEAST_TIMES", 1)
    run(tmp_path, "--methods", "--json", tmp_path / "found.json")
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("1 clips, measured on meshes; filmed lips are")
    assert [*told[2].split()[:3]] == ["head", "film", "facefx"]
    for table in ("aperture", "width"):
        (row,) = (one for one in told if one.split()[:3] == [table, "times", "film"])
        assert row.endswith("held shapes")
    assert any(one.startswith("bmp  ") for one in told)
    assert '"apertures"' in (tmp_path / "found.json").read_text()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["-c", "arkit"], "arkit has no model"),
        (["-c", "facef"], "did you mean 'facefx'"),
        (["--render"], "--render needs a --tracker"),
        ([], "holds no films with a text"),
        (["own"], "own: its lips are not tracked; name a --tracker"),
        (["bare"], r"bare_texts\.tsv, or the lips beside it: FileNotFoundError"),
        (["odd"], r"odd_texts\.tsv, or the lips beside it: KeyError: 'width'"),
        (["own", "--clip", "two"], "two is no clip of .*: own"),
        (["own", "--tracker", "no-python"], "--tracker no-python: "),
    ],
)
def test_what_cannot_be_compared_is_refused_in_a_sentence(run, tmp_path, arguments, why):
    if "own" in arguments:
        (tmp_path / "own.mp4").touch()
        (tmp_path / "own.txt").write_text("hello")
        arguments = arguments[1:]
    if arguments in (["bare"], ["odd"]):
        (tmp_path / f"{arguments[0]}_texts.tsv").write_text("clip\ttext\n")
        with gzip.open(tmp_path / "odd_lips.tsv.gz", "wt") as stream:
            stream.write("clip\tsecond\tinner_gap\na\t1\t1\n")
        arguments = []
    with pytest.raises(SystemExit, match=why):
        run(tmp_path, *arguments)
