"""Live voice: the pace of sound, what is missing of it, and texts between."""

import numpy as np
import pytest
from fake_listener import FakeListener
from test_live import LINE, Taken, Time

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.production.live.live_player import LivePlayer
from lipsync_lang.production.live.live_voice import MAX_QUEUED_SECONDS, LiveVoice

RATE = 16_000


def tone(seconds, rate=RATE, level=0.5):
    return np.full(round(seconds * rate), level, np.float32)


def session(arrivals, until, *, step=0.004, end=None, **how):
    """Offer sound at its times, and return frames with the time at which they came, and remarks."""
    told, found, left = [], [], sorted(arrivals, key=lambda one: one[0])
    voice = LiveVoice(FakeListener, 60, told.append, **how)
    for now in np.arange(0, until, step).tolist():
        while left and left[0][0] <= now:
            _, rate, sound = left.pop(0)
            voice.offer(rate, sound)
        if end is not None and now >= end:
            voice.end()
            end = None
        found += [(now, frame) for frame in voice.frames(now)]
    return voice, found, told


def chunks(start, count, seconds, rate=RATE, pace=1.0):
    """Return chunks of live sound, each of which arrives when it has been recorded."""
    return [(start + n * seconds * pace, rate, tone(seconds, rate)) for n in range(count)]


def late(found):
    return [now - frame.seconds for now, frame in found]


def test_a_recording_moves_the_mouth_as_long_as_it_lasts():
    voice, found, told = session([(0.0, RATE, tone(4.0))], 5, end=0.0)
    assert told == []
    assert not voice.busy
    times = [frame.seconds for _, frame in found]
    assert times[0] == pytest.approx(0.2 + 0.08, abs=0.01)
    assert times[-1] - times[0] == pytest.approx(4.3, abs=0.05)
    assert np.diff(times) == pytest.approx(1 / 60, abs=1e-3)
    assert max(map(abs, late(found)[:-6])) < 0.03  # the last ones, at rest, come together


@pytest.mark.parametrize("seconds", [0.01, 0.02, 0.125])
def test_live_sound_is_heard_without_a_delay_that_grows(seconds):
    _, found, told = session(chunks(1.0, round(10 / seconds), seconds), 11)
    assert told == []
    behind = [now - 1.0 - number / 60 for number, (now, _) in enumerate(found)]
    assert behind[0] == pytest.approx(0.08, abs=0.03)
    assert max(behind) < 0.08 + seconds + 0.02
    gaps = np.diff([now for now, _ in found])
    assert gaps.max() < 0.04  # even for sound that comes in large parts


@pytest.mark.parametrize("pace", [0.99, 1.01])
def test_a_clock_of_another_speed_adds_no_delay(pace):
    _, found, told = session(chunks(1.0, 1500, 0.02, pace=pace), 31)
    assert told == []
    behind = [now - 1.0 - number / 60 * pace for number, (now, _) in enumerate(found)]
    assert max(behind) < 0.08 + 0.02 + 0.03


def test_sound_that_waited_for_the_session_is_heard_at_once():
    early = [(0.0, RATE, tone(2.0))]
    _, found, _ = session(early + chunks(0.21, 100, 0.02), 2)
    shown = [now for now, _ in found]
    assert sum(now < 0.25 for now in shown) > 110
    assert shown[-1] == pytest.approx(2, abs=0.05)
    assert len(found) == pytest.approx((2 + 1.79 - 0.08) * 60, abs=4)


def test_a_short_delay_is_made_up_at_once():
    parts = chunks(1.0, 200, 0.02)
    held = [(max(at, 2.0) if 1.8 < at <= 2.0 else at, *rest) for at, *rest in parts]
    _, found, told = session(held, 5)
    assert told == []
    behind = [now - 1.0 - number / 60 for number, (now, _) in enumerate(found)]
    assert behind[-1] < 0.25


def test_missing_sound_is_silence_and_told():
    parts = [*chunks(1.0, 50, 0.02), *chunks(6.0, 50, 0.02)]
    _, found, told = session(parts, 7)
    assert told == [
        "no sound has arrived for 2 s; the mouth rests until it goes on",
        "the sound goes on",
    ]
    levels = {round(now, 1): frame.weights.max() for now, frame in found}
    assert levels[1.9] == 0.5
    assert levels[3.0] == levels[5.9] == 0
    assert levels[6.5] == 0.5
    assert np.diff([now for now, _ in found]).max() < 0.4


def test_another_rate_is_told_and_heard():
    parts = [*chunks(1.0, 50, 0.02), *chunks(2.0, 50, 0.02, 48_000)]
    _, found, told = session(parts, 3)
    assert told == ["the sound goes on at 48000 samples per second"]
    assert len(found) == pytest.approx((2 - 0.08) * 60, abs=4)


def test_a_rate_that_sound_does_not_keep_is_told_once():
    _, _, told = session(chunks(1.0, 600, 0.02, 48_000, pace=1.5), 19)
    assert len(told) == 1
    assert "arrives too slowly, about 31" in told[0]
    assert "of 48000 samples per second; is its rate right?" in told[0]


def test_a_microphone_is_heard_at_once():
    _, found, _ = session(chunks(1.0, 100, 0.01), 2, paced=False)
    behind = [now - 1.0 - number / 60 for number, (now, _) in enumerate(found)]
    assert max(behind) < 0.08 + 0.015


def test_too_much_sound_is_refused_and_another_source_too():
    voice = LiveVoice(FakeListener, 60, print)
    voice.claim("one")
    with pytest.raises(LipsyncError, match="has a voice already"):
        voice.claim("other")
    voice.offer(RATE, tone(MAX_QUEUED_SECONDS))
    with pytest.raises(LipsyncError, match="5 s of sound wait already"):
        voice.offer(RATE, tone(0.1), wait=False)
    voice.release("other")
    voice.release("one")
    voice.claim("other")


def test_a_text_goes_before_the_voice_and_no_pose_jumps():
    performer = ll.resolve("english", "facefx")
    time, told = Time(), []
    taken = Taken(time)
    voice = LiveVoice(FakeListener, 60, told.append)
    player = LivePlayer(performer, 60, [taken], voice=voice, clock=time.clock, wait=time.wait)
    sound = iter(chunks(0.3, 150, 0.02))
    due = [next(sound)]

    def more():
        while due and due[0][0] <= time.now:
            voice.offer(*due.pop()[1:])
            due.extend([*[next(sound, None)]])
            if due == [None]:
                due.clear()
        if time.now > 1 and not told:
            told.append(player.say(LINE))
        return time.now < 4

    player.run(more)
    times = [frame.seconds for frame in taken.frames]
    assert times == sorted(times)
    shown = np.array([frame.weights for frame in taken.frames if frame.seconds < 3])
    begun = next(n for n, frame in enumerate(taken.frames) if frame.weights.max() > 0.4)
    limit = performer.motion.speed_limit / 60 + 0.5 / 12 + 1e-3
    assert np.abs(np.diff(shown[begun:], axis=0)).max() <= limit
    heard = {round(f.seconds, 1): bool(np.allclose(f.weights, 0.5)) for f in taken.frames}
    assert [heard[at] for at in (0.9, 1.4, 2.9)] == [True, False, True]


class Restless(FakeListener):
    """A listener that hears a voice in silence."""

    def push(self, samples):
        final = super().push(samples)
        return final._replace(weights=final.weights * 0 + 0.1)

    def finish(self):
        return self.push(np.zeros(0))


def test_the_mouth_rests_after_a_voice_whatever_was_heard():
    time = Time()
    taken = Taken(time)
    voice = LiveVoice(Restless, 60, print)
    performer = ll.resolve("english", "facefx")
    player = LivePlayer(performer, 60, [taken], voice=voice, clock=time.clock, wait=time.wait)
    voice.offer(RATE, tone(1.0))
    voice.end()
    player.run(lambda: time.now < 3)
    shown = [float(frame.weights.max()) for frame in taken.frames]
    assert max(shown) == pytest.approx(0.1)
    assert shown[-1] == 0
    assert np.abs(np.diff(shown[2:])).max() < 0.02
