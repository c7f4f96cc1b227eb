"""The command that opens the studio."""

import argparse
import logging
import sys
from argparse import Namespace
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.commands.output import SOUND
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_motion, add_pair, add_values, cleaning
from lipsync_lang.errors import LipsyncError
from lipsync_lang.extras import install_line

if TYPE_CHECKING:
    import socket

LOCAL = "127.0.0.1"
"""Address of this machine, for itself only."""

TOKEN_BYTES = 18
"""Length of a random token in bytes."""

LEAST_TOKEN_CHARS = 16
"""Minimum length of a token from the user."""

MAX_PORT = 65535

SHUTDOWN_SECONDS = 1
"""Time for open requests when the studio closes."""


@command("studio")
def add_studio(add: Add) -> None:
    """Add `studio`."""
    studio_ = add(
        "studio",
        studio,
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
        "--host", metavar="ADDRESS", default=LOCAL,
        help="the address to listen on; needs --token for other machines [this machine only]",
    )  # fmt: skip
    studio_.add_argument("--token", metavar="SECRET", help="the secret in the address [random]")
    studio_.add_argument(
        "--browser", action=argparse.BooleanOptionalAction, default=True,
        help="open the address in a browser [yes]",
    )  # fmt: skip


def studio(options: Namespace) -> int:
    """Open the studio in a browser, until it is interrupted."""
    import threading
    import webbrowser
    from hashlib import sha256

    try:
        import uvicorn

        from lipsync_lang.studio.server import app
    except ImportError:
        what = f"the studio needs Starlette and uvicorn: {install_line('studio')}"
        raise LipsyncError(what) from None
    from platformdirs import user_state_path

    from lipsync_lang.commands.performing import motion_settings
    from lipsync_lang.packs.project import find_project
    from lipsync_lang.studio.desk import Desk
    from lipsync_lang.studio.project_lines import ProjectLines
    from lipsync_lang.studio.workshop import Workshop

    token = _token(options)
    # Unsaved edits are kept outside the project, in a file of its own.
    name = sha256(str(Path.cwd().resolve()).encode()).hexdigest()[:16]
    journal = user_state_path("lipsync-lang") / "studio" / f"{name}.jsonl"
    workshop = Workshop(
        Path.cwd(), options.path, Desk(journal),
        motion=motion_settings(options.settings), engine=options.tts, cleaning=cleaning(options),
        script=ProjectLines(find_project(), options.path),
    )  # fmt: skip
    workshop.settings.fps = options.fps
    if options.language and options.character:
        workshop.open_restored(options.language, options.character)
    with _listening(options.host, options.port) as listener:
        port = listener.getsockname()[1]
        names = {options.host, *((LOCAL, "localhost") if options.host == LOCAL else ())}
        hosts = [f"{name}:{port}" for name in names]
        address = f"http://{options.host}:{port}/{token}/"
        print(f"the studio is at {address}", flush=True)
        print("close it with Ctrl-C; unsaved edits are kept", file=sys.stderr)
        if options.browser:
            threading.Timer(0.3, webbrowser.open, (address,)).start()
        config = uvicorn.Config(
            app(workshop, token, hosts), log_level=logging.WARNING, access_log=False,
            lifespan="off", ws="none", server_header=False,
            timeout_graceful_shutdown=SHUTDOWN_SECONDS,
        )  # fmt: skip
        with suppress(KeyboardInterrupt):  # the usual end of a studio
            uvicorn.Server(config).run(sockets=[listener])
    return SOUND


def _token(options: Namespace) -> str:
    """Return the secret part of the address; the user must choose it for other machines."""
    from secrets import token_urlsafe

    if options.token is None:
        if options.host != LOCAL:
            raise LipsyncError(
                f"--host {options.host} lets other machines in: choose a secret for the address "
                "with --token SECRET"
            )
        return token_urlsafe(TOKEN_BYTES)
    token: str = options.token
    if len(token) < LEAST_TOKEN_CHARS or not token.replace("-", "").replace("_", "").isalnum():
        raise LipsyncError(
            f"--token: use at least {LEAST_TOKEN_CHARS} letters, digits, - and _, such as "
            f"{token_urlsafe(TOKEN_BYTES)}"
        )
    if options.host != LOCAL:
        print(
            f"warning: every machine that reaches {options.host} and knows the token can change "
            "the packs of this folder; the connection is not encrypted",
            file=sys.stderr,
        )
    return token


def _listening(host: str, port: int) -> "socket.socket":
    """Return a listening socket."""
    import socket

    if not 0 <= port <= MAX_PORT:
        what = f"--port {port}: give a number from 1 to {MAX_PORT}, or 0 for a free one"
        raise LipsyncError(what)
    try:
        return socket.create_server((host, port))
    except OSError as error:
        what = f"--host {host} --port {port}: cannot be used: {error}; port 0 takes a free one"
        raise LipsyncError(what) from None
