"""Live: bytes of packets, the clock, clients of a WebSocket, and refusals."""

import json
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from contextlib import closing, suppress

import numpy as np
import pytest
from fake_listener import FakeListener
from lanes import full

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.cli import main
from lipsync_lang.commands.live import lines
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.production.live.addresses import LiveAddress, parse_address
from lipsync_lang.production.live.live_frame import LiveFrame
from lipsync_lang.production.live.live_player import (
    MAX_SPOKEN_CHARS,
    MAX_WAITING_TEXTS,
    LivePlayer,
    TextSpeaker,
)
from lipsync_lang.production.live.live_voice import LiveVoice
from lipsync_lang.production.live.outlets import LiveLinkPacket, PacketOutlet, vmc_messages
from lipsync_lang.production.live.web_socket import MAX_PHONEME_ROWS, Client, Session

PAIR = ("-l", "english", "-c", "arkit")
LINE = Schedule(("HH", "AY", "M", "AA"), [0, 0.1, 0.3, 0.4, 0.6], notation="arpabet")


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


# Addresses


def test_addresses_have_usual_hosts_and_ports():
    assert parse_address("livelink") == ("livelink", "127.0.0.1", 11111)
    assert parse_address("vmc:39540") == ("vmc", "127.0.0.1", 39540)
    assert parse_address("vmc:pc.local") == ("vmc", "pc.local", 39539)
    assert parse_address("ws:[::1]:80") == ("ws", "::1", 80)
    assert parse_address("-") == ("-", "", 0)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("vcm:1.2.3.4:5", "did you mean 'vmc'"),
        ("127.0.0.1:11111", "not a kind of receiver"),
        ("ws:127.0.0.1:port", "'port' is not a port"),
        ("ws:127.0.0.1:99999", "'99999' is not a port"),
        ("ws:127.0.0.1:-1", "'-1' is not a port"),
        ("", "not a kind of receiver"),
    ],
)
def test_other_addresses_are_refused(text, match):
    with pytest.raises(LipsyncError, match=match):
        parse_address(text)


# Packets


def test_a_packet_of_live_link_is_as_the_app_sends_it():
    columns = [Channel("jawOpen"), Channel("mouthLeft"), Channel("tongueOut")]
    pack = LiveLinkPacket(columns, 30000 / 1001, "Ada", start=1000)
    raw = pack(LiveFrame(2.5 * 1001 / 30000, np.array([0.25, 0.5, 2.0])))
    assert raw[:5] == b"\x06\x00\x00\x00\x24"  # version, and the length of the device
    device, rest = raw[5:41].decode(), raw[41:]
    assert [len(part) for part in device.split("-")] == [8, 4, 4, 4, 12]
    assert rest[:7] == b"\x00\x00\x00\x03Ada"
    assert rest[7:24] == bytes.fromhex("000003ea 3f000000 00007530 000003e9 3d")
    values = struct.unpack(">61f", rest[24:])
    assert {n: v for n, v in enumerate(values) if v} == {17: 0.25, 21: 0.5, 51: 1.0}
    assert pack(LiveFrame(0.0, np.zeros(3)))[5:41] == raw[5:41]


def test_a_face_without_shapes_of_arkit_is_refused(performer):
    with pytest.raises(OutputError, match="ARKit's shapes alone"):
        LiveLinkPacket(performer.channels, 60, "Ada")


def test_a_bundle_of_vmc_has_a_value_for_each_pose_and_applies_them():
    raw = vmc_messages(("aa", "ih"), {"ih": "I"})(LiveFrame(0.0, np.array([0.5, 0.25])))
    expected = (
        b"#bundle\0" + struct.pack(">Q", 1)
        + osc(b"/VMC/Ext/OK", b",i", struct.pack(">i", 1))
        + osc(b"/VMC/Ext/Blend/Val", b",sf", b"aa\0\0" + struct.pack(">f", 0.5))
        + osc(b"/VMC/Ext/Blend/Val", b",sf", b"I\0\0\0" + struct.pack(">f", 0.25))
        + osc(b"/VMC/Ext/Blend/Apply", b",", b"")
    )  # fmt: skip
    assert raw == expected


def osc(address, types, values):
    """An OSC message after its length; texts are filled up to fours with zeros."""
    text = b"".join(part + b"\0" * (4 - len(part) % 4) for part in (address, types))
    return struct.pack(">i", len(text + values)) + text + values


def test_an_unknown_host_is_told(monkeypatch):
    def unknown(*_, **__):
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    with pytest.raises(LipsyncError, match=r"no host 'nowhere.invalid'"):
        PacketOutlet(LiveAddress("vmc", "nowhere.invalid", 39539), lambda _: b"", print)


def test_an_engine_that_does_not_listen_is_told_once_and_sent_on():
    told = []
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as engine:
        engine.bind(("127.0.0.1", 0))
        address = LiveAddress("vmc", "127.0.0.1", engine.getsockname()[1])
        outlet = PacketOutlet(address, lambda frame: b"%.1f" % frame.seconds, told.append)
        outlet.send(LiveFrame(0.0, np.zeros(1)))
        assert engine.recv(9) == b"0.0"
    for number in range(1, 20):
        outlet.send(LiveFrame(number / 10, np.zeros(1)))
    assert len(told) == 1
    assert "does not listen; start the engine, frames are sent on" in told[0]
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as engine:
        engine.bind(address[1:])
        engine.settimeout(5)
        for number in range(20, 40):
            outlet.send(LiveFrame(number / 10, np.zeros(1)))
        found = [engine.recv(9) for _ in range(20)]
    outlet.close()
    assert found == [b"%.1f" % (number / 10) for number in range(20, 40)]
    assert told[1:] == [f"vmc: 127.0.0.1:{address.port} gets frames again"]


def test_a_network_that_fails_is_told_and_the_session_goes_on(monkeypatch):
    told = []
    outlet = PacketOutlet(LiveAddress("vmc", "127.0.0.1", 39539), lambda _: b"x", told.append)

    def fail(_):
        raise OSError(101, "Network is unreachable")

    monkeypatch.setattr(outlet, "_send", fail)
    for number in range(5):
        outlet.send(LiveFrame(number / 60, np.zeros(1)))
    outlet.close()
    assert told == [
        "vmc: 127.0.0.1:39539 gets no frames (Network is unreachable); check the network"
    ]


# By the clock


class Time:
    """A clock that moves only by waiting."""

    def __init__(self):
        self.now = 0.0

    def clock(self):
        return self.now

    def wait(self, seconds):
        self.now += seconds + 1e-4


class Taken:
    """An outlet that records frames and events."""

    def __init__(self, time):
        self.time, self.frames, self.told, self.at = time, [], [], []

    def send(self, frame):
        self.frames.append(frame)
        self.at.append(self.time.now)

    def tell(self, event):
        self.told.append(event)

    def close(self):
        pass


def played(performer, *schedules, ticks=400, fps=60, **how):
    time = Time()
    taken = Taken(time)
    player = LivePlayer(performer, fps, [taken], how, clock=time.clock, wait=time.wait)
    for schedule in schedules:
        player.say(schedule)
    left = iter(range(ticks))
    player.run(lambda: next(left, None) is not None)
    return player, taken


def test_frames_are_those_of_the_file_at_their_time(performer):
    _, taken = played(performer, LINE)
    whole = performer.perform(LINE)
    start = taken.told[0]["start"]
    spoken = [f for f in taken.frames if f.weights.any()]
    found = np.array([f.weights for f in spoken])
    shown = whole.weights[whole.weights.any(axis=1)]
    assert np.abs(found - shown).max() < 1e-9
    times = whole.times[whole.weights.any(axis=1)]
    assert np.abs(np.array([f.seconds for f in spoken]) - start - times).max() < 1e-4
    late = [at - f.seconds for at, f in zip(taken.at, taken.frames, strict=True)]
    assert min(late) >= -1e-6
    assert max(late) < 2 / 60


def test_a_style_has_its_posture_after_the_poses_of_speech():
    smiling = ll.resolve("english", "arkit")
    _, taken = played(smiling, LINE, styles={"happy": 1})
    whole = smiling.perform(LINE, styles={"happy": 1})
    assert len(whole.poses) > len(smiling.poses)
    found = np.array([f.weights for f in taken.frames if f.weights.any()])
    assert np.abs(found - whole.weights[whole.weights.any(axis=1)]).max() < 1e-6
    assert {len(f.weights) for f in taken.frames} == {len(whole.poses)}


def test_what_comes_while_another_is_spoken_waits(performer):
    player, taken = played(performer, LINE, LINE)
    first, second = (event["start"] for event in taken.told)
    assert second == pytest.approx(first + 0.6, abs=1e-3)
    moved = LINE.times[1:] + 0.6
    both = Schedule(LINE.labels * 2, [*LINE.times, *moved], notation="arpabet")
    shown = performer.perform(both).weights
    found = np.array([f.weights for f in taken.frames if f.weights.any()])
    assert np.abs(found - shown[shown.any(axis=1)]).max() < 1e-9
    assert player.resting


def test_the_mouth_rests_between_and_is_sent_now_and_then(performer):
    _, taken = played(performer, ticks=200)
    assert not any(f.weights.any() for f in taken.frames)
    assert 6 <= len(taken.frames) <= 9


def test_an_interrupted_mouth_comes_to_rest(performer):
    time = Time()
    taken = Taken(time)
    player = LivePlayer(performer, 60, [taken], clock=time.clock, wait=time.wait)
    player.say(LINE)
    ticks = iter(range(25))

    def more():
        if next(ticks, None) is None:
            raise KeyboardInterrupt
        return True

    with pytest.raises(KeyboardInterrupt):
        player.run(more)
    assert taken.frames[-1].weights.any()
    player.rest()
    assert not taken.frames[-1].weights.any()
    moved = np.abs(np.diff([f.weights for f in taken.frames], axis=0)).max()
    assert moved <= performer.motion.speed_limit / 60 + 1e-9


# Texts


def test_texts_are_spoken_sentence_by_sentence_and_failures_are_told():
    spoken, said, told = [], threading.Event(), []

    def speak(text):
        spoken.append(text)
        if text == "Bad!":
            raise LipsyncError("no")
        if text == "End":
            said.set()
        return text

    done = []
    speaker = TextSpeaker(speak, done.append, told.append)
    assert speaker.say("One. Two?  Bad! 三。四") == 0
    speaker.say("End")
    assert said.wait(10)
    assert spoken == ["One.", "Two?", "Bad!", "三。", "四", "End"]
    assert told == ["no"]
    for text, match in (("  ", "the text is empty"), ("x" * (MAX_SPOKEN_CHARS + 1), "more than")):
        with pytest.raises(LipsyncError, match=match):
            speaker.say(text)


def test_only_so_many_texts_wait():
    held = threading.Event()
    speaker = TextSpeaker(lambda _: held.wait(10), lambda _: None, print)
    for number in range(MAX_WAITING_TEXTS):
        assert speaker.say("x") == number
    with pytest.raises(LipsyncError, match="wait already"):
        speaker.say("x")
    held.set()


def test_lines_are_read_as_they_come(tmp_path):
    path = tmp_path / "lines"
    path.write_bytes("one\nzwölf\r\n".encode() + b"\xff" + b"x" * 200_000 + b"\nlast")
    with path.open() as stream:
        found = list(lines(stream))
    assert found[:2] == ["one", "zwölf\r"]
    assert found[-1] == "last"
    assert all(len(line) <= 2 * 65536 for line in found)


# Clients


@pytest.fixture
def client(performer):
    said = []

    def say(text):
        said.append(text)
        return len(said) - 1

    voice = LiveVoice(performer.listen, 60, print)
    made = Client(
        Session(
            {}, say, lambda notation, _: performer.stream(60, notation=notation or "arpabet"),
            lambda rate, delay: FakeListener(rate, delay or 0.08), voice,
        )
    )  # fmt: skip
    made.said = said
    return made


def test_a_client_sends_phonemes_and_gets_the_frames_of_the_file(client, performer):
    rows = list(zip(LINE.labels, LINE.times[:-1].tolist(), LINE.times[1:].tolist(), strict=True))
    frames = []
    for row in rows:
        answer = client.answer(json.dumps({"phonemes": [row]}))
        frames += answer["frames"]
    assert answer["known"] == 0.6
    frames += client.answer('{"finish": true}')["frames"]
    whole = performer.perform(LINE)
    assert np.abs(np.array([f["weights"] for f in frames]) - whole.weights).max() <= 1e-5
    assert [f["time"] for f in frames] == pytest.approx(whole.times.tolist(), abs=1e-5)
    again = client.answer('{"phonemes": [["AA", 0, null]], "known_until": 0.3, "finish": true}')
    assert again["known"] == 0.3
    assert client.answer('{"text": "Hello"}') == {"waiting": 0}
    assert client.said == ["Hello"]


@pytest.mark.parametrize(
    ("message", "match"),
    [
        ("", "not JSON"),
        ("[" * 100_000, "not JSON"),
        (b"\xff\xfe\0", "ends within a sample"),
        ("[1]", "not a JSON object"),
        ("{}", "the message is empty; the fields of a message are"),
        ('{"words": 1}', "unknown field 'words'"),
        ('{"text": 1}', "`text` must be a string"),
        ('{"text": "a", "finish": true}', "the only field"),
        ('{"phonemes": "AA"}', "rows of label, start and end"),
        ('{"phonemes": [["AA", 0]]}', "such as"),
        ('{"phonemes": [[5, 0, 1]]}', "is not a label"),
        ('{"phonemes": [["AA", "0", 1]]}', "not a time"),
        ('{"phonemes": [["AA", NaN, 1]]}', "finite"),
        ('{"phonemes": [["AA", 0, Infinity]]}', "finite"),
        ('{"phonemes": [["AA", 0, 1' + "0" * 400 + "]]}", "not a time"),
        ('{"phonemes": [["AA", 1, 0]]}', "before it starts"),
        ('{"phonemes": [["QQ", 0, 1]]}', "'QQ'"),
        ('{"phonemes": [["AA", 0, 1], ["M", 0.5, 2]]}', "late"),
        ('{"phonemes": [["AA", 0, 1], ["M", 900, 901]]}', "give times in seconds"),
        ('{"phonemes": [["AA", 0, 1]], "known_until": 1e300}', "give times in seconds"),
        ('{"phonemes": [["AA", 0, 1]], "known_until": []}', "not a time"),
        ('{"known_until": 1}', "feed a phoneme first"),
        ('{"revise": "now"}', "not a time"),
        ('{"finish": true}', "no phonemes"),
        ('{"notation": "morse"}', "morse"),
        ('{"notation": 3}', "name of a notation"),
    ],
)
def test_a_bad_message_gets_a_stated_answer(client, message, match):
    assert match in client.answer(message)["error"]
    assert client.answer('{"text": "still here"}') == {"waiting": 0}


def test_a_message_has_so_many_phonemes(client):
    rows = [["AA", n / 100, (n + 1) / 100] for n in range(MAX_PHONEME_ROWS + 1)]
    assert "at most" in client.answer(json.dumps({"phonemes": rows}))["error"]


# Whole, over sockets of this machine


@pytest.fixture
def receiver():
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as one:
        one.bind(("127.0.0.1", 0))
        one.settimeout(20)
        yield one


@full
def test_the_command_speaks_to_unreal_and_to_vmc(receiver):
    port = receiver.getsockname()[1]
    raw = sent(receiver, ["live", "map", *PAIR, "--to", f"livelink:127.0.0.1:{port}"])
    assert {len(one) for one in raw} == {1 + 4 + 36 + 4 + 7 + 16 + 1 + 61 * 4}
    jaw = [struct.unpack(">61f", one[-244:])[17] for one in raw]
    assert max(jaw) > 0.2
    assert jaw[-1] == 0
    frames = [struct.unpack(">i", one[52:56])[0] for one in raw]
    assert frames == sorted(frames)
    raw = sent(receiver, ["live", "map", *PAIR, "--to", f"vmc:{port}", "--rename", "jawOpen=A"])
    assert all(one.startswith(b"#bundle\0") and b"/VMC/Ext/Blend/Apply" in one for one in raw)
    assert b",sf\0A\0\0\0" in raw[0]


def sent(receiver, arguments):
    """Run the command, and return the data that the receiver got."""
    found = []

    def receive():
        with suppress(TimeoutError):
            while True:
                found.append(receiver.recv(65536))
                receiver.settimeout(1)

    thread = threading.Thread(target=receive)
    thread.start()
    assert main(arguments) == 0
    thread.join(20)
    return found


@pytest.fixture
def server(performer):
    from lipsync_lang.production.live.web_socket import WebSocketOutlet

    said = []
    greeting = {"poses": performer.poses}
    session = Session(
        greeting, lambda text: said.append(text) or 0, lambda *_: performer.stream(),
        lambda rate, delay: FakeListener(rate, delay or 0.08), LiveVoice(FakeListener, 60, print),
    )  # fmt: skip
    made = WebSocketOutlet(LiveAddress("ws", "127.0.0.1", 0), session)
    made.said = said
    yield made
    made.close()


def opened(server, **how):
    from websockets.sync.client import connect

    return connect(f"ws://127.0.0.1:{server.port}", compression=None, **how)


@full
def test_clients_get_frames_and_are_answered(server, performer):
    with opened(server) as one, opened(server, origin="http://localhost:3000") as other:
        for client in (one, other):
            assert json.loads(client.recv(10)) == {"poses": list(performer.poses)}
        one.send("nonsense")
        assert "not JSON" in json.loads(one.recv(10))["error"]
        one.send('{"text": "Hello"}')
        assert json.loads(one.recv(10)) == {"waiting": 0}
        one.send('{"phonemes": [["m", 0, 0.2], ["_", 0.2, 2]]}')
        assert len(json.loads(one.recv(10))["frames"]) > 60
    with opened(server) as last:
        last.recv(10)
        while len(server.clients) != 1:  # the two before it have left
            time.sleep(0.01)
        server.send(LiveFrame(0.5, np.full(len(performer.poses), 0.25)))
        assert json.loads(last.recv(10)) == {"time": 0.5, "weights": [0.25] * 9}
    assert server.said == ["Hello"]


@full
def test_foreign_pages_and_large_messages_are_refused(server):
    from websockets.exceptions import ConnectionClosed, InvalidStatus

    for origin in ("https://example.com", "http://localhost.example.com", "null"):
        with pytest.raises(InvalidStatus, match="403"):
            opened(server, origin=origin)
    with opened(server) as client:
        client.recv(10)
        client.send("x" * 70_000)
        with pytest.raises(ConnectionClosed, match="1009"):
            client.recv(10)
    assert server.said == []


@full
def test_a_taken_port_is_told(server):
    from lipsync_lang.production.live.web_socket import WebSocketOutlet

    with pytest.raises(LipsyncError, match=r"cannot listen at 127.0.0.1:.*another port"):
        WebSocketOutlet(LiveAddress("ws", "127.0.0.1", server.port), server.session)


@full
def test_ctrl_c_ends_with_the_mouth_at_rest():
    command = [sys.executable, "-m", "lipsync_lang.cli", "live", *PAIR]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as process:
        process.stdin.write("A long sentence about many maps and more.\n")
        process.stdin.flush()
        for line in process.stdout:
            if any(json.loads(line).get("weights", ())):
                break
        process.send_signal(signal.SIGINT)
        rest, words = process.communicate(timeout=60)
    assert process.returncode == 0, words
    assert "Traceback" not in words
    assert not any(json.loads(rest.splitlines()[-1])["weights"])


@full
def test_a_voice_is_followed_without_a_text_or_a_language(tmp_path, capfd):
    spoken = ll.speak("My map and a boat.", "english")
    ll.resolve("english", "vrm").perform(spoken).save(tmp_path / "line.wav")
    assert main(["live", "--audio", str(tmp_path / "line.wav"), "-c", "vrm"]) == 0
    greeting, *rows = map(json.loads, capfd.readouterr().out.splitlines())
    assert greeting["delay"] == 0.08
    times = [row["time"] for row in rows]
    assert times == sorted(times)
    assert times[-1] - times[1] == pytest.approx(spoken.audio.seconds + 0.5, abs=0.4)
    weights = np.array([row["weights"] for row in rows])
    assert weights[:, 0].max() > 0.25
    assert not weights[-1].any()


@full
def test_piped_sound_is_followed_and_its_faults_are_named():
    command = [sys.executable, "-m", "lipsync_lang.cli", "live", "--audio", "-", "-c", "vrm"]
    raw = np.zeros(16_000, "<i2").tobytes() + b"\0"
    done = subprocess.run(command, input=raw, capture_output=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(rows) > 60
    assert not any(any(row.get("weights", ())) for row in rows)
    assert done.stderr.decode().splitlines() == [
        "lipsync-lang: the sound ends within a sample: 1 of 2 bytes are left out"
    ]
    for raw, match in ((b"", "no sound came"), (b"fLaC" + bytes(9), "the sound is FLAC")):
        done = subprocess.run(command, input=raw, capture_output=True, timeout=120, check=False)
        assert done.returncode == 2
        assert match in done.stderr.decode()


@pytest.mark.parametrize("package", ["starlette", "uvicorn", "websockets"])
def test_a_package_that_the_page_lacks_is_named_before_it_opens(cli, monkeypatch, package):
    hidden = [name for name in sys.modules if name.split(".")[0] == package]
    for name in [*hidden, package, "lipsync_lang.studio.voice_page"]:
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, package, None)
    ended = cli("live", "--page", "--no-browser", *PAIR)
    assert ended.code == 2
    assert f"the page needs the package {package}" in ended.err
    assert "[studio]" in ended.err
    assert not ended.out


@pytest.mark.parametrize(
    ("options", "match"),
    [
        (["Hello", "--audio", "-"], "a TEXT is for speech of a text; leave it out with --audio"),
        (["--audio", "-", "--style", "angry:1"], "--style is for speech"),
        (["--page", "--style", "angry:1"], "--style is not for the page"),
        (["--rate", "8000"], "give a source with --audio"),
        (["--audio", "none.wav"], "none.wav: cannot be read"),
        (["--audio", "-", "--rate", "5"], "--rate 5: give the samples per second"),
        (["--audio", "-", "--format", "wav"], "'wav' is not a format of samples"),
    ],
)
def test_options_of_sound_that_cannot_be_are_refused(cli, options, match):
    ended = cli("live", *options, *PAIR)
    assert ended.code == 2
    assert match in ended.err
