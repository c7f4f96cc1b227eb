"""Serving of a page at an address with a secret, for the commands that open a browser."""

import argparse
import logging
import sys
from argparse import Namespace
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from lipsync_lang.errors import LipsyncError
from lipsync_lang.extras import install_line

if TYPE_CHECKING:
    import socket
    from collections.abc import Callable, Collection

    from starlette.types import ASGIApp

LOCAL = "127.0.0.1"
"""Address of this machine, for itself only."""

TOKEN_BYTES = 18
"""Length of a random token in bytes."""

LEAST_TOKEN_CHARS = 16
"""Minimum length of a token from the user."""

MAX_PORT = 65535

SHUTDOWN_SECONDS = 1
"""Time for open requests when the server closes."""


def add_serving(add: argparse._ActionsContainer) -> None:
    """Add the options of an address to a command or a group of options."""
    add.add_argument(
        "--port", metavar="N", type=int, default=0, help="the port to listen on [a free one]"
    )
    add.add_argument(
        "--host", metavar="ADDRESS", default=LOCAL,
        help="the address to listen on; needs --token for other machines [this machine only]",
    )  # fmt: skip
    add.add_argument("--token", metavar="SECRET", help="the secret in the address [random]")
    add.add_argument(
        "--browser", action=argparse.BooleanOptionalAction, default=True,
        help="open the address in a browser [yes]",
    )  # fmt: skip


def serve(
    options: Namespace,
    what: str,
    end: str,
    open_app: "Callable[[str, Collection[str]], ASGIApp]",
    **settings: Any,
) -> None:
    """Serve an application until it is interrupted, and open its address in a browser.

    Parameters
    ----------
    options : those of `add_serving`
    what : the name of the page in messages
    end : how to end it
    open_app : takes the token and the accepted `Host` headers; may lack a package
    settings : further settings of uvicorn
    """
    import threading
    import webbrowser

    token = _token(options)
    with _listening(options.host, options.port) as listener:
        port = listener.getsockname()[1]
        names = {options.host, *((LOCAL, "localhost") if options.host == LOCAL else ())}
        hosts = [f"{name}:{port}" for name in names]
        try:
            import uvicorn

            page = open_app(token, hosts)
        except ImportError:
            needs = f"{what} needs Starlette and uvicorn: {install_line('studio')}"
            raise LipsyncError(needs) from None
        address = f"http://{options.host}:{port}/{token}/"
        print(f"{what} is at {address}", flush=True)
        print(end, file=sys.stderr)
        if options.browser:
            threading.Timer(0.3, webbrowser.open, (address,)).start()
        config = uvicorn.Config(
            page, log_level=logging.WARNING, access_log=False, lifespan="off",
            server_header=False, timeout_graceful_shutdown=SHUTDOWN_SECONDS, **settings,
        )  # fmt: skip
        with suppress(KeyboardInterrupt):  # the usual end
            uvicorn.Server(config).run(sockets=[listener])


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
