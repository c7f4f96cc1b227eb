"""Sound of clients of a WebSocket: voices of their own, the voice of all, and refusals."""

import json

import numpy as np
import pytest
from fake_listener import FakeListener
from lanes import full
from test_live import LINE, opened

import lipsync_lang as ll
from lipsync_lang.production.live.addresses import LiveAddress
from lipsync_lang.production.live.live_voice import LiveVoice
from lipsync_lang.production.live.web_socket import Client, Session, WebSocketOutlet

BLOCK = np.full(320, 8192, "<i2").tobytes()
"""20 ms at 16,000 samples per second."""


@pytest.fixture
def session():
    performer = ll.resolve("english", "facefx")
    made = LiveVoice(FakeListener, 60, print)
    return Session(
        {}, lambda _: 0, lambda notation, _: performer.stream(60, notation=notation or "arpabet"),
        lambda rate, delay: FakeListener(rate, 0.08 if delay is None else delay), made,
    )  # fmt: skip


def asked(client, **message):
    return client.answer(json.dumps(message))


def test_a_voice_of_a_client_has_its_own_frames(session):
    client = Client(session)
    frames = []
    for number in range(50):
        answer = client.answer(BLOCK)
        assert answer["heard"] == pytest.approx((number + 1) / 50)
        assert answer["belief"] == [0.25, 0.75]
        frames += answer["frames"]
    frames += asked(client, finish=True)["frames"]
    assert [one["time"] for one in frames] == pytest.approx(np.arange(61) / 60, abs=1e-5)
    assert frames[0]["weights"] == [0.25] * 9
    assert client.answer(BLOCK)["heard"] == 0.02  # a new voice
    assert not session.voice.busy


def test_the_settings_of_a_voice_are_answered_and_may_change(session):
    client = Client(session)
    told = asked(client, sound={"rate": 48_000, "format": "f32", "delay": 0.1})
    assert told == {
        "listening": {
            "rate": 48_000, "format": "f32", "phones": ("A", "B"), "delay": 0.1,
            "delays": {"belief": 0.1},
        },
        "frames": [],
    }  # fmt: skip
    sound = np.full(9600, 0.5, "<f4").tobytes()
    first = client.answer(sound)
    assert first["heard"] == 0.2
    assert [one["time"] for one in first["frames"]] == pytest.approx(np.arange(7) / 60, abs=1e-5)
    told = asked(client, sound={"rate": 16_000})
    assert (told["listening"]["rate"], told["listening"]["delay"]) == (16_000, 0.08)
    assert len(told["frames"]) == 6  # the end of the voice before
    assert client.answer(BLOCK)["frames"] == []


def test_voices_do_not_mix(session):
    one, other = Client(session), Client(session)
    asked(other, sound={"rate": 8_000})
    assert (one.answer(BLOCK)["heard"], other.answer(BLOCK)["heard"]) == (0.02, 0.04)


def test_sound_for_all_is_the_voice_of_the_session_and_has_one_source(session):
    one, other = Client(session), Client(session)
    assert asked(one, sound={"for": "all"}) == {
        "listening": {"rate": 16_000, "format": "s16"}, "frames": [],
    }  # fmt: skip
    assert one.answer(BLOCK) == {"heard": 0.02}
    assert session.voice.busy
    assert "has a voice already" in asked(other, sound={"for": "all"})["error"]
    assert other.answer(BLOCK)["heard"] == 0.02  # its own
    asked(one, finish=True)
    assert "listening" in asked(other, sound={"for": "all"})
    for _ in range(300):
        told = other.answer(BLOCK)
    assert "send sound as it is spoken" in told["error"]


@pytest.mark.parametrize(
    ("message", "match"),
    [
        ({"sound": 5}, "must be an object"),
        ({"sound": {"rates": 8000}}, "did you mean 'rate'"),
        ({"sound": {"rate": 5}}, "samples per second"),
        ({"sound": {"rate": 16000.5}}, "samples per second"),
        ({"sound": {"format": "mp3"}}, "not a format of samples"),
        ({"sound": {"delay": "0.1"}}, "number of seconds"),
        ({"sound": {"delay": True}}, "number of seconds"),
        ({"sound": {"for": "me"}}, '`for` must be "all"'),
        ({"sound": {"for": "all", "delay": 0.1}}, "`--delay`"),
        ({"sound": {}, "text": "a"}, "only field"),
    ],
)
def test_odd_settings_are_refused_and_the_voice_goes_on(session, message, match):
    client = Client(session)
    client.answer(BLOCK)
    assert match in asked(client, **message)["error"]
    assert client.answer(BLOCK)["heard"] == 0.04


def test_a_torn_message_is_not_heard(session):
    client = Client(session)
    client.answer(BLOCK)
    told = client.answer(BLOCK[:-1])["error"]
    assert told.startswith("a message of 639 bytes ends within a sample of s16")
    assert client.answer(BLOCK)["heard"] == 0.04
    assert client.answer(b"")["frames"] == []


def test_phonemes_and_sound_of_a_client_are_apart(session):
    client = Client(session)
    client.answer(BLOCK)
    rows = list(zip(LINE.labels, LINE.times[:-1].tolist(), LINE.times[1:].tolist(), strict=True))
    asked(client, phonemes=rows)
    assert "known" in asked(client, finish=True)  # of the stream
    assert "belief" in asked(client, finish=True)  # of the voice


@full
def test_a_client_that_leaves_gives_the_voice_back(session):
    server = WebSocketOutlet(LiveAddress("ws", "127.0.0.1", 0), session)
    try:
        with opened(server) as one:
            one.recv(10)
            one.send('{"sound": {"for": "all"}}')
            one.recv(10)
            one.send(BLOCK)
            assert json.loads(one.recv(10)) == {"heard": 0.02}
            assert session.voice.owner is not None
        with opened(server) as other:
            other.recv(10)
            for _ in range(100):
                other.send('{"sound": {"for": "all"}}')
                told = json.loads(other.recv(10))
                if "listening" in told:
                    break
            assert "listening" in told
    finally:
        server.close()
