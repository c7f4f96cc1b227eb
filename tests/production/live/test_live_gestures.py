"""Live gestures: faces blink and breathe between texts, and move beside them, within speed."""

import json

import numpy as np
import pytest
from test_live import LINE, Taken, Time

import lipsync_lang as ll
from lipsync_lang.production.live.live_gestures import LiveGestures
from lipsync_lang.production.live.live_player import LivePlayer
from lipsync_lang.production.live.live_voice import LiveVoice
from lipsync_lang.production.live.web_socket import Client, Session


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "arkit")


def opened(performer, fps=60):
    own = performer.gesture_set
    return LiveGestures(own, [1.0] * len(own.shapes), fps)


def lived(performer, *schedules, ticks):
    """Return the lips and the gestures of a session, the times, and the player."""
    time = Time()
    taken = Taken(time)
    player = LivePlayer(performer, 60, [taken], gestures=opened(performer), clock=time.clock,
                        wait=time.wait)  # fmt: skip
    for schedule in schedules:
        player.say(schedule)
    left = iter(range(ticks))
    player.run(lambda: next(left, None) is not None)
    player.end()
    weights = np.array([frame.weights for frame in taken.frames])
    count = len(performer.poses)
    return weights[:, :count], weights[:, count:], [f.seconds for f in taken.frames], player


def test_a_silent_face_blinks_and_breathes_without_a_step(performer):
    lips, moved, times, _ = lived(performer, ticks=60 * 60)
    own = performer.gesture_set
    assert not lips.any()
    shut = moved[:, own.poses.index("eyeBlinkLeft")] > 0.9
    assert 8 <= np.count_nonzero(np.diff(shut.astype(int)) == 1) <= 26
    assert moved[:, own.poses.index("lift")].max() > 0.5
    step = np.abs(np.diff(moved, axis=0))
    assert (step <= own.speed * np.maximum(np.diff(times), 1 / 60)[:, None] + 1e-9).all()
    assert not moved[-1].any()


def test_a_spoken_text_has_its_gestures_and_the_same_lips(performer):
    words = ("M", "AA1", "M", "AH0", "T", "IY1", "S", "OW1", "D", "AH0")
    line = ll.Schedule(words * 4, np.arange(41) * 0.12, notation="arpabet")
    lips, moved, *_ = lived(performer, line, ticks=400)
    spoken = lips[lips.any(axis=1)]
    shown = performer.perform(line).weights
    assert np.abs(spoken - shown[shown.any(axis=1)]).max() < 1e-9
    own = performer.gesture_set
    assert moved[:, own.poses.index("nod")].max() > 2
    assert (moved >= own.low).all()
    assert (moved <= own.high).all()


def client_of(performer, open_gestures):
    def stream(notation, moving):
        gestures = "all" if moving else None
        return performer.stream(60, notation=notation or "arpabet", stress=True, gestures=gestures)

    voice = LiveVoice(performer.listen, 60, print)
    return Client(Session({}, len, stream, performer.listen, voice, open_gestures))


def test_a_client_may_ask_for_the_gestures_of_its_line(performer):
    client = client_of(performer, lambda: opened(performer))
    words = ("M", "AA1", "M", "AH0", "T", "IY1", "S", "OW1", "D", "AH0")
    line = ll.Schedule((*words * 4, "_"), np.arange(42) * 0.12, notation="arpabet")
    rows = [*zip(line.labels, line.times[:-1].tolist(), line.times[1:].tolist(), strict=True)]
    first = client.answer(json.dumps({"gestures": True, "ends_at": 5.5, "phonemes": rows[:20]}))
    assert 1 < first["delay"] < 2
    again = client.answer(json.dumps({"gestures": False}))
    assert "first message of a stream" in again["error"]
    last = client.answer(json.dumps({"phonemes": rows[20:], "known_until": 5.5, "finish": True}))
    found = [frame["weights"] for frame in first["frames"] + last["frames"]]
    assert first["frames"]
    ended = ll.Schedule(line.labels, [*line.times[:-1], 5.5], notation="arpabet")
    whole = performer.perform(ended, gestures="all")
    assert np.abs(np.array(found) - whole.weights).max() < 1e-4


@pytest.mark.parametrize(
    ("asked", "match"), [("yes", "must be true or false"), (True, "start it with --gestures all")]
)
def test_gestures_that_a_client_cannot_have_are_refused(performer, asked, match):
    client = client_of(performer, lambda: None)
    assert match in client.answer(json.dumps({"gestures": asked, "phonemes": []}))["error"]


def test_clients_get_gestures_beside_their_own_frames(performer):
    client = client_of(performer, lambda: opened(performer))
    rows = [*zip(LINE.labels, LINE.times[:-1].tolist(), LINE.times[1:].tolist(), strict=True)]
    answer = client.answer(json.dumps({"phonemes": rows, "finish": True}))
    counts = {len(frame["weights"]) for frame in answer["frames"]}
    assert counts == {len(performer.poses) + len(performer.gesture_set.poses)}
