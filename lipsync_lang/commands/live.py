"""The command that animates a character live."""

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from threading import Thread
from typing import TYPE_CHECKING, Any, TextIO

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.commands.local_server import serve
from lipsync_lang.commands.output import SOUND
from lipsync_lang.commands.registry import handler

if TYPE_CHECKING:
    from starlette.types import ASGIApp

    from lipsync_lang.performing.gesturing import GestureScales
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.production.live.addresses import LiveAddress
    from lipsync_lang.production.live.live_gestures import LiveGestures
    from lipsync_lang.production.live.live_player import LivePlayer, TextSpeaker
    from lipsync_lang.production.live.sound_bytes import Pcm
    from lipsync_lang.production.live.sound_sources import SoundFeed
    from lipsync_lang.production.live.web_socket import Session
    from lipsync_lang.sound.listening.listener import Listener

MAX_LINE_BYTES = 64 * 1024
"""Maximum number of bytes of a line of standard input; a longer line is split."""


@handler(
    "live",
    "speak typed sentences or follow a voice, and send frames to an engine in real time",
    'live "Hello, world" -l english -c facefx --to vmc:127.0.0.1:39539\n'
    "  lipsync-lang live --audio mic -c facefx --to vmc:127.0.0.1:39539",
)
def live(options: Namespace) -> int:
    """Send frames of texts and voices in real time when they arrive, until the input ends."""
    if options.choosing:
        return _list_microphones()
    from lipsync_lang.commands.performing import levels, performer_for
    from lipsync_lang.performing.gesturing import ALL
    from lipsync_lang.production.live.addresses import STANDARD_OUTPUT, parse_address
    from lipsync_lang.production.live.live_player import LivePlayer, TextSpeaker
    from lipsync_lang.production.live.live_voice import LiveVoice
    from lipsync_lang.production.live.sound_sources import is_microphone
    from lipsync_lang.production.live.web_socket import Session
    from lipsync_lang.sound.speech.sound import SPEECH_RATE

    addresses = [parse_address(one) for one in dict.fromkeys(options.to or [STANDARD_OUTPUT])]
    performer, fps = performer_for(options), options.fps
    styles = levels("--style", options.styles)
    how: dict[str, Any] = {"styles": styles, "dials": levels("--dial", options.dials)}
    stream = performer.stream(fps, **how)  # settings that cannot stream are refused here

    def listen(rate: int, delay: float | None = None) -> "Listener":
        awaited = options.delay if delay is None else delay
        return performer.listen(rate, awaited, fps, poses=stream.poses)

    # Before any receiver is opened, so that a microphone that is missing leaves engines alone.
    source = _source(options)
    voice = LiveVoice(listen, fps, _complain, paced=not is_microphone(options.audio))
    delay = stream.delay
    if source is not None or options.page:  # a model that is missing is told here
        delay = listen(options.rate or SPEECH_RATE).delay
    asked = options.gestures or (ALL if options.page else None)
    open_gestures = _gestures(asked, performer, fps)
    player = LivePlayer(
        performer, fps, [], how, voice=voice, gestures=open_gestures(), wait=voice.wait
    )
    speaker = TextSpeaker(
        lambda text: performer.speaker.speak(text, engine=options.tts), player.say, _complain
    )
    poses = stream.poses + (performer.gesture_set.poses if player.gestures else ())
    greeting = {"poses": poses, "fps": fps, "delay": round(delay, 4)}
    session = Session(
        greeting, speaker.say,
        lambda notation, moving: performer.stream(
            fps, notation=notation, gestures=asked if moving else None, **how
        ),
        listen, voice, open_gestures,
    )  # fmt: skip
    if options.page:
        _serve_page(options, performer, session)
    else:
        _send(options, addresses, player, speaker, session=session, source=source)
    return SOUND


def _gestures(
    asked: "GestureScales | None", performer: "Performer", fps: float
) -> "Callable[[], LiveGestures | None]":
    """Return a function that opens the gestures asked for."""
    from lipsync_lang.performing.gesturing import scales_of
    from lipsync_lang.production.live.live_gestures import LiveGestures

    scales = scales_of(performer.compiled, asked)
    return lambda: None if scales is None else LiveGestures(performer.gesture_set, scales, fps)


def _serve_page(options: Namespace, performer: "Performer", session: "Session") -> None:
    """Serve the page of a voice until it is interrupted."""
    from lipsync_lang.production.live.web_socket import MAX_MESSAGE_BYTES

    for name, given in (("a TEXT", options.text), ("--audio", options.audio),
                          ("--to", options.to), ("--tts", options.tts),
                          ("--style", options.styles), ("--dial", options.dials)):  # fmt: skip
        if given:
            raise LipsyncError(f"{name} is not for the page; leave it out with --page")

    def open_app(token: str, hosts: Collection[str]) -> "ASGIApp":
        import websockets  # noqa: F401 without it, uvicorn opens the page and refuses its sound

        from lipsync_lang.studio.voice_page import voice_app

        return voice_app(performer, session, token, hosts)

    end = "allow it the microphone, and talk; close it with Ctrl-C"
    serve(options, "the page", end, open_app, ws_max_size=MAX_MESSAGE_BYTES)


def _send(  # noqa: PLR0913 who speaks, and who receives it
    options: Namespace,
    addresses: "Sequence[LiveAddress]",
    player: "LivePlayer",
    speaker: "TextSpeaker",
    *,
    session: "Session",
    source: "Iterator[Pcm] | None",
) -> None:
    """Open the receivers, and perform all input for them."""
    from lipsync_lang.production.live.outlets import outlet
    from lipsync_lang.production.live.sound_sources import SoundFeed

    renamed = _renamed(options.rename, [channel.name for channel in player.channels])
    try:
        for address in addresses:
            receiver = outlet(
                address, player, session, subject=options.subject, renamed=renamed,
                complain=_complain,
            )  # fmt: skip
            player.outlets.append(receiver)
        for one in player.outlets:
            one.tell(session.greeting)
        serving = any(address.kind == "ws" for address in addresses)
        feed = None if source is None else SoundFeed(source, session.voice)
        _play(options.text, player, speaker, feed, serving=serving)
    finally:
        for one in player.outlets:
            one.close()


def _renamed(stated: list[str], poses: Sequence[str]) -> dict[str, str]:
    """Parse ``POSE=NAME`` of known poses."""
    renamed = dict(one.partition("=")[::2] for one in stated)
    for name, other in renamed.items():
        if not name or not other:
            raise LipsyncError(f"--rename {name}: write POSE=NAME, such as --rename mouth_open=A")
        if name not in poses:
            hint = did_you_mean(name, poses)
            raise LipsyncError(f"--rename {name}: unknown pose '{name}'; {hint}")
    return renamed


def _source(options: Namespace) -> "Iterator[Pcm] | None":
    """Open the source of sound; None without one."""
    from lipsync_lang.production.live.sound_bytes import checked_form
    from lipsync_lang.production.live.sound_sources import open_source

    form = checked_form(options.rate, options.format)
    if options.audio is None:
        if options.rate is not None or options.format is not None:
            raise LipsyncError("--rate and --format are of sound; give a source with --audio")
        return None
    for name, given in (("a TEXT", options.text), ("--tts", options.tts),
                          ("--style", options.styles), ("--dial", options.dials)):  # fmt: skip
        if given:
            raise LipsyncError(f"{name} is for speech of a text; leave it out with --audio")
    return open_source(options.audio, form, options.rate, _complain)


def _list_microphones() -> int:
    from lipsync_lang.base.presentation.text_table import columns
    from lipsync_lang.production.live.sound_sources import devices

    found = devices()
    rows = [(str(one.number), one.name, f"{one.rate} Hz", "usual" * one.usual) for one in found]
    print("\n".join(columns(rows)) if rows else "no microphone is plugged in")
    return SOUND


def _play(
    text: str | None, player: "LivePlayer", speaker: "TextSpeaker", feed: "SoundFeed | None", *,
    serving: bool,
) -> None:  # fmt: skip
    """Perform all input until its end or the user's interrupt, and leave the mouth at rest."""
    reading: Thread | None = None
    if text is not None:
        speaker.say(text)
    elif feed is None:
        print("type what to say, line by line; end with Ctrl-C", file=sys.stderr)
        # A daemon, since nothing can wake a thread that waits for a line of standard input.
        reading = Thread(target=_read, args=(speaker,), daemon=True)
        reading.start()

    def more() -> bool:
        if feed is not None and feed.error is not None:
            raise feed.error
        heard = feed is not None and (feed.alive or feed.voice.busy)
        return serving or heard or speaker.busy or (reading is not None and reading.is_alive())

    with suppress(KeyboardInterrupt):  # the usual end
        try:
            player.run(more)
        finally:
            player.end()


def _read(speaker: "TextSpeaker") -> None:
    """Speak every line of standard input."""
    for line in lines(sys.stdin):
        try:
            if line.strip():
                speaker.say(line)
        except LipsyncError as error:
            _complain(str(error))


def lines(stream: TextIO) -> Iterator[str]:
    """Yield lines when they arrive; a thread that waits for a line does not delay the end."""
    try:
        number = stream.fileno()
    except OSError:
        yield from stream
        return
    rest = b""
    # Not `for line in stream`: Python would hold a lock at its end, and fill a buffer before.
    while more := os.read(number, MAX_LINE_BYTES):
        *whole, rest = (rest + more).split(b"\n")
        if len(rest) > MAX_LINE_BYTES:
            whole, rest = [*whole, rest], b""
        yield from (line.decode("utf-8", "replace") for line in whole)
    yield rest.decode("utf-8", "replace")


def _complain(message: str) -> None:
    print(f"lipsync-lang: {message}", file=sys.stderr, flush=True)
