"""Serving of a page at an address with a secret, for the commands that open a browser."""

import logging
import os
import stat
import sys
from argparse import Namespace
from contextlib import suppress
from pathlib import Path
from time import time
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extras import install_line

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

ADDRESS_SECONDS = 7 * 24 * 3600
"""Time for which a kept address is used again."""

SHUTDOWN_SECONDS = 1
"""Time for open requests when the server closes."""


MAX_PRIVATE_BYTES = 4096


def serve(
    options: Namespace,
    what: str,
    end: str,
    open_app: "Callable[[str, Collection[str]], ASGIApp]",
    kept: Path | None = None,
    **settings: Any,
) -> None:
    """Serve an application until it is interrupted, and open its address in a browser.

    Parameters
    ----------
    options : those of the set `serving`
    what : the name of the page in messages
    end : how to end it
    open_app : takes the token and the accepted `Host` headers; may lack a package
    kept : private file of the address, so that open pages find the next server; None for a new one
    settings : further settings of uvicorn
    """
    import threading
    import webbrowser

    listener, token = _address(options, kept)
    with listener:
        port = listener.getsockname()[1]
        host = f"[{options.host}]" if ":" in options.host else options.host
        names = {host, *((LOCAL, "localhost") if host == LOCAL else ())}
        hosts = [f"{name}:{port}" for name in names]
        try:
            import uvicorn

            page = open_app(token, hosts)
        except ImportError as error:
            needs = f"{what} needs the package {error.name}: {install_line('studio')}"
            raise LipsyncError(needs) from None
        address = f"http://{host}:{port}/{token}/"
        print(f"{what} is at {address}", flush=True)
        print(end, file=sys.stderr)
        if options.browser:
            # The socket listens already, so an early browser waits until the address is printed.
            threading.Timer(0.3, webbrowser.open, (address,)).start()
        config = uvicorn.Config(
            page, log_level=logging.WARNING, access_log=False, lifespan="off",
            server_header=False, timeout_graceful_shutdown=SHUTDOWN_SECONDS, **settings,
        )  # fmt: skip
        with suppress(KeyboardInterrupt):  # the usual end
            uvicorn.Server(config).run(sockets=[listener])


def _address(options: Namespace, kept: Path | None) -> "tuple[socket.socket, str]":
    """Return a listening socket and the token: those of the server before, if it kept them.

    A token holds for its port alone, since another program on that port may have been sent it.
    """
    from secrets import token_urlsafe

    token = _token(options)
    if kept is None or token is not None or options.host != LOCAL:
        return listening(options.host, options.port), token or token_urlsafe(TOKEN_BYTES)
    before = _read(kept)
    if before is not None and options.port in {0, before[0]}:
        with suppress(LipsyncError):  # the port is taken
            return listening(LOCAL, before[0]), before[1]
    listener, token = listening(LOCAL, options.port), token_urlsafe(TOKEN_BYTES)
    with suppress(OSError):  # open pages then need the new address
        write_private(kept, f"{listener.getsockname()[1]} {token}".encode())
    return listener, token


def _read(kept: Path) -> tuple[int, str] | None:
    """Return the port and the token in a private file; None if it has none, or old ones."""
    content, written = read_private(kept) or (b"", 0.0)
    port, _, token = content.decode("ascii", "replace").partition(" ")
    valid = port.isdecimal() and 0 < int(port) <= MAX_PORT and _sound(token)
    return (int(port), token) if valid and time() - written < ADDRESS_SECONDS else None


def _sound(token: str) -> bool:
    return len(token) >= LEAST_TOKEN_CHARS and token.replace("-", "").replace("_", "").isalnum()


def _token(options: Namespace) -> str | None:
    """Return the user's token; None for a random one, which is for this machine only."""
    from secrets import token_urlsafe

    if options.token is None:
        if options.host != LOCAL:
            raise LipsyncError(
                f"--host {options.host} lets other machines in: choose a secret for the address "
                "with --token SECRET"
            )
        return None
    token: str = options.token
    if not _sound(token):
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


def listening(host: str, port: int, backlog: int | None = None) -> "socket.socket":
    """Return a listening socket with a queue of new connections; port 0 is a free one."""
    import socket

    if not 0 <= port <= MAX_PORT:
        what = f"--port {port}: give a number from 1 to {MAX_PORT}, or 0 for a free one"
        raise LipsyncError(what)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family, backlog=backlog)
    except OSError as error:
        what = f"--host {host} --port {port}: cannot be used: {error}; port 0 takes a free one"
        raise LipsyncError(what) from None
    # The head and the body of an answer are two packets; without this, the second waits some 40 ms.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener


def write_private(path: Path, content: bytes) -> None:
    """Replace a file by a new one that only its owner can read; raise OSError if that fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileNotFoundError):
        path.unlink()
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    with os.fdopen(os.open(path, flags, 0o600), "wb") as stream:
        stream.write(content)


def read_private(path: Path) -> tuple[bytes, float] | None:
    """Return a file's content and the time of its writing.

    The result is None if there is no such file, if it is a link, if it belongs to somebody else, or
    if others may read or write it. Windows keeps files of a user's profile private without modes.
    """
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        with os.fdopen(os.open(path, flags), "rb") as stream:
            found = os.fstat(stream.fileno())
            shared = os.name == "posix" and (found.st_uid != os.getuid() or found.st_mode & 0o077)
            if shared or not stat.S_ISREG(found.st_mode):
                return None
            return stream.read(MAX_PRIVATE_BYTES), found.st_mtime
    except OSError:
        return None
