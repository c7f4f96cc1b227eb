"""The command that animates a character live."""

import os
import sys
from argparse import Namespace
from collections.abc import Iterator
from threading import Thread
from typing import TYPE_CHECKING, Any, TextIO

from lipsync_lang.commands.output import SOUND
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_manner, add_pair, add_values
from lipsync_lang.errors import LipsyncError
from lipsync_lang.files.signals import Terminated

if TYPE_CHECKING:
    from lipsync_lang.live.live_player import LivePlayer, TextSpeaker
    from lipsync_lang.live.outlets import Outlet

MAX_LINE_BYTES = 64 * 1024
"""Maximum number of bytes of a line of standard input; a longer line is split."""


@command("live")
def add_live(add: Add) -> None:
    """Add `live`."""
    live_ = add(
        "live",
        live,
        "speak typed sentences, and send their frames to an engine in real time",
        'live "Hello, world" -l english -c facefx --to vmc:127.0.0.1:39539',
    )
    live_.add_argument(
        "text", metavar="TEXT", nargs="?", help="the text to say [lines from standard input]"
    )
    add_pair(live_)
    add_values(live_)
    live_.add_argument(
        "--to", metavar="RECEIVER", action="append", default=[],
        help="livelink:HOST:PORT (Unreal), vmc:HOST:PORT (VSeeFace, Unity), ws:HOST:PORT (serve "
        "WebSockets), or - for lines of JSON; may be repeated [-]",
    )  # fmt: skip
    live_.add_argument("--tts", metavar="ENGINE", help="speech engine; none is silent")
    live_.add_argument(
        "--subject", metavar="NAME", default="lipsync", help="the Live Link subject [lipsync]"
    )
    live_.add_argument(
        "--rename", metavar="POSE=NAME", action="append", default=[],
        help="send a pose to vmc under another name; may be repeated",
    )  # fmt: skip
    add_manner(live_)


def live(options: Namespace) -> int:
    """Speak texts when they arrive, and send their frames in real time, until the input ends."""
    from lipsync_lang.commands.performing import levels, performer_for
    from lipsync_lang.live.live_player import LivePlayer, TextSpeaker
    from lipsync_lang.live.outlets import STANDARD_OUTPUT, outlet, parse_address, refuse_unknown
    from lipsync_lang.live.web_socket import Session

    addresses = [parse_address(one) for one in dict.fromkeys(options.to or [STANDARD_OUTPUT])]
    performer, fps = performer_for(options), options.fps
    renamed = dict(one.partition("=")[::2] for one in options.rename)
    for name, other in renamed.items():
        if not name or not other:
            raise LipsyncError(f"--rename {name}: write POSE=NAME, such as --rename mouth_open=A")
    refuse_unknown(renamed, performer.poses)
    styles = levels("--style", options.styles)
    how: dict[str, Any] = {"styles": styles, "dials": levels("--dial", options.dials)}
    delay = performer.stream(fps, **how).delay  # settings that cannot stream are refused here
    outlets: list[Outlet] = []
    player = LivePlayer(performer, fps, outlets, how)
    speaker = TextSpeaker(
        lambda text: performer.speaker.speak(text, engine=options.tts), player.say, _complain
    )
    greeting = {"poses": performer.poses, "fps": fps, "delay": round(delay, 4)}
    session = Session(
        greeting, speaker.say, lambda notation: performer.stream(fps, notation=notation, **how)
    )
    try:
        for address in addresses:
            subject = options.subject
            outlets.append(
                outlet(address, performer, fps, session, subject=subject, renamed=renamed)
            )
        for one in outlets:
            one.tell(greeting)
        serving = any(address.kind == "ws" for address in addresses)
        _play(options.text, player, speaker, serving=serving)
    finally:
        for one in outlets:
            one.close()
    return SOUND


def _play(text: str | None, player: "LivePlayer", speaker: "TextSpeaker", *, serving: bool) -> None:
    """Perform all input until its end or the user's interrupt, and leave the mouth at rest."""
    reading: Thread | None = None
    if text is not None:
        speaker.say(text)
    else:
        print("type what to say, line by line; end with Ctrl-C", file=sys.stderr)
        reading = Thread(target=_read, args=(speaker,), daemon=True)
        reading.start()

    def more() -> bool:
        return serving or speaker.busy or (reading is not None and reading.is_alive())

    try:
        player.run(more)
    except KeyboardInterrupt:  # the usual end
        player.rest()
    except Terminated:
        player.rest()
        raise


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
    while more := os.read(number, MAX_LINE_BYTES):
        *whole, rest = (rest + more).split(b"\n")
        if len(rest) > MAX_LINE_BYTES:
            whole, rest = [*whole, rest], b""
        yield from (line.decode("utf-8", "replace") for line in whole)
    yield rest.decode("utf-8", "replace")


def _complain(message: str) -> None:
    print(f"lipsync-lang: {message}", file=sys.stderr, flush=True)
