"""Options of the commands that stay open: live and studio."""

import argparse

from lipsync_lang.commands import live, studio
from lipsync_lang.commands.script_options import add_values
from lipsync_lang.commands.shared_options import Add, add_manner, add_motion, add_pair


def add_live(add: Add) -> None:
    """Add `live`."""
    live_ = add(
        "live",
        live.live,
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


def add_studio(add: Add) -> None:
    """Add `studio`."""
    studio_ = add(
        "studio",
        studio.studio,
        "open the studio in a browser: play, explain and edit a line",
        "studio -l english -c facefx",
    )
    add_pair(studio_)
    add_values(studio_)
    studio_.set_defaults(choosing=True)
    studio_.add_argument("--tts", metavar="ENGINE", help="speech engine; none is silent")
    add_motion(studio_)
    studio_.add_argument(
        "--port", metavar="N", type=int, default=0, help="the port to listen on [a free one]"
    )
    studio_.add_argument(
        "--host", metavar="ADDRESS", default=studio.LOCAL,
        help="the address to listen on; needs --token for other machines [this machine only]",
    )  # fmt: skip
    studio_.add_argument("--token", metavar="SECRET", help="the secret in the address [random]")
    studio_.add_argument(
        "--browser", action=argparse.BooleanOptionalAction, default=True,
        help="open the address in a browser [yes]",
    )  # fmt: skip
