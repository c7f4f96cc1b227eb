"""Server of a study: serves only its page, and stores answers.

Answers are checked, appended to one file and never changed. Every connection carries one request,
with a deadline and a maximum size, and requests from other sites are refused.
"""

import asyncio
import json
import logging
import os
import time
from collections import deque
from collections.abc import Collection
from hashlib import blake2b
from http import HTTPStatus
from ipaddress import ip_address
from pathlib import Path
from threading import Lock
from typing import Any, Self
from urllib.parse import urlsplit

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.middleware.cors import CORSMiddleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route
from uvicorn.protocols.http.h11_impl import H11Protocol

from lipsync_lang import LipsyncError
from lipsync_lang.commands.local_server import listening
from lipsync_lang.plugins.study.study_file import (
    MAX_ANSWERS_BYTES,
    MAX_SUBMISSION_BYTES,
    STUDY_NAME,
    Study,
    Submission,
    as_text,
    faults_against,
    parsed,
    read_study,
    refuse_links,
)
from lipsync_lang.plugins.study.study_maker import PAGE
from lipsync_lang.plugins.study.study_page import UNPOSTED, origin_of

ANSWERS = "answers.jsonl"
POST_PATH = "/answers"

REQUEST_SECONDS = 30.0
"""Time limit for the arrival of a request."""

FINISHING_SECONDS = 1
"""Time for open requests when the server closes."""

SEND_SECONDS = 60.0
"""Time limit for a client to take the part of a response that is ready."""

PART_BYTES = 2**16
"""Size of the parts in which the page is sent."""

MAX_CONNECTIONS = 64

MAX_PER_MINUTE = 60
"""Maximum number of submissions per minute and address; a laboratory shares one address."""

MAX_ADDRESSES = 10_000
"""Maximum number of addresses in memory."""

RESPONSE_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cache-Control": "no-store",
    "Connection": "close",  # one request per connection, so that one deadline covers both
}
"""Headers of every response; the page itself states a stricter policy."""

MAX_WAITING = 128
"""Queue of new connections, such as those of a class; the system resets those beyond."""


class AnswerLog:
    """File of answers, to which submissions are appended."""

    def __init__(self, path: Path, study: Study) -> None:
        self.path = path
        self._study = study
        self._lock = Lock()
        try:
            content = path.read_bytes() if path.exists() else b""
        except OSError as error:
            raise LipsyncError(f"{path}: cannot be read: {error.strerror}") from None
        self._known = {_digest(line) for line in content.split(b"\n") if line}
        """Digests of the lines in the file."""

    def add(self, content: bytes) -> tuple[HTTPStatus, str]:
        """Append a submission, and return the HTTP status and an error message.

        A submission already in the file counts as stored, since a browser may send it twice.
        """
        try:
            submission = parsed(Submission, content, "answers")
        except LipsyncError as error:
            return HTTPStatus.UNPROCESSABLE_ENTITY, str(error)
        faults = faults_against(submission, self._study)
        if faults:
            return HTTPStatus.UNPROCESSABLE_ENTITY, faults[0]
        line = as_text(submission).encode()
        digest = _digest(line.rstrip(b"\n"))
        with self._lock:
            if digest in self._known:
                return HTTPStatus.OK, ""
            # Opened for each submission: an editor may replace the file while the study runs.
            handle = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
            with os.fdopen(handle, "rb+", buffering=0) as file:
                size = file.seek(0, os.SEEK_END)
                if size + len(line) > MAX_ANSWERS_BYTES:
                    return HTTPStatus.INSUFFICIENT_STORAGE, "the file of answers is full"
                if size and file.seek(size - 1) and file.read(1) != b"\n":
                    line = b"\n" + line  # a write before was cut off
                file.write(line)
                # A rater who is thanked cannot be asked again after a loss of power.
                os.fsync(file.fileno())
            self._known.add(digest)
        return HTTPStatus.CREATED, ""


def _digest(line: bytes) -> bytes:
    return blake2b(line, digest_size=16).digest()


class AnswerConnection(H11Protocol):
    """HTTP connection with the deadlines that uvicorn lacks."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Limit the time of the request, and drop connections beyond `MAX_CONNECTIONS`."""
        super().connection_made(transport)
        transport.set_write_buffer_limits(high=0)  # `pause_writing` at any byte that waits
        self._sending: asyncio.TimerHandle | None = None
        self.loop.call_later(REQUEST_SECONDS, self._end_slow_request)
        if len(self.connections) > MAX_CONNECTIONS:
            transport.abort()

    def _end_slow_request(self) -> None:
        if self.cycle is None or self.cycle.more_body:
            self.transport.abort()

    def pause_writing(self) -> None:
        """Start the time limit of a client that takes nothing."""
        super().pause_writing()
        # `close` would wait for the client to take the rest.
        self._sending = self.loop.call_later(SEND_SECONDS, self.transport.abort)

    def resume_writing(self) -> None:
        """End the time limit."""
        super().resume_writing()
        if self._sending is not None:
            self._sending.cancel()


class StudySite:
    """The addresses of a study: its page, and the place to which pages of `origins` may post."""

    def __init__(self, page: bytes, log: AnswerLog, origins: frozenset[str]) -> None:
        self._page, self._log, self._origins = page, log, origins
        self._hosts = {urlsplit(one).netloc for one in origins} - {""}
        self._recent: dict[str, deque[float]] = {}

    def app(self) -> Starlette:
        """Return the site as an ASGI application."""
        routes = [
            Route("/", self.send_page),
            Route(f"/{PAGE}", self.send_page),
            Route(POST_PATH, self.take_answers, methods=["POST"]),
        ]
        cors = Middleware(
            CORSMiddleware, allow_origins=[*self._origins], allow_methods=["POST"],
            allow_headers=["content-type"],
        )  # fmt: skip
        refusals = {HTTPException: _refusal}
        return Starlette(routes=routes, middleware=[cors], exception_handlers=refusals)

    async def send_page(self, request: Request) -> Response:
        """Send the page."""
        self._refuse_other_sites(request)
        whole = memoryview(self._page)
        parts = (whole[at : at + PART_BYTES] for at in range(0, len(whole), PART_BYTES))
        length = {"Content-Length": str(len(whole))}
        return StreamingResponse(parts, headers=length, media_type="text/html")

    async def take_answers(self, request: Request) -> Response:
        """Store the answers of a rater."""
        self._refuse_other_sites(request)
        # A post that cannot be a submission is refused before its content arrives.
        if request.headers.get("Content-Type", "").partition(";")[0].strip() != "application/json":
            raise HTTPException(415, "send the answers as application/json")
        # Without a length, an endless body would fill the memory.
        length = request.headers.get("Content-Length")
        if length is None:
            raise HTTPException(411, "the header Content-Length is missing")
        if int(length) > MAX_SUBMISSION_BYTES:  # h11 accepts only decimal digits
            raise HTTPException(413, "the answers are too long")
        try:
            content = await request.body()
        except ClientDisconnect:
            raise HTTPException(408, "the answers did not arrive in full") from None
        now = time.monotonic()
        # All at once, which is cheap, and forgets only the counts of a minute.
        if len(self._recent) > MAX_ADDRESSES:
            self._recent.clear()
        address = request.client.host if request.client else ""
        times = self._recent.setdefault(address, deque(maxlen=MAX_PER_MINUTE))
        if len(times) == MAX_PER_MINUTE and times[0] > now - 60:
            raise HTTPException(429, "too many answers; wait a minute")
        times.append(now)
        try:
            status, fault = await run_in_threadpool(self._log.add, content)
        except OSError:
            raise HTTPException(507, "the answers cannot be stored") from None
        if fault:
            raise HTTPException(status, fault)
        return _json({"taken": True}, status)

    def _refuse_other_sites(self, request: Request) -> None:
        host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
        try:  # no other site can take over a numeric address, or localhost
            name = urlsplit(f"//{host}").hostname or ""
            numeric = name == "localhost" or bool(ip_address(name))
        except ValueError:
            numeric = False
        if not numeric and host not in self._hosts:
            raise HTTPException(421, "this address is not that of the study")
        if origin is not None and origin not in {f"http://{host}", *self._origins}:
            raise HTTPException(403, "requests from other sites are refused")


def _refusal(_: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)  # noqa: S101 registered for these
    return _json({"error": error.detail}, error.status_code)


def _json(content: dict[str, Any], status: int) -> Response:
    return Response(json.dumps(content), status, media_type="application/json")


class AnswerServer:
    """A server of the study in a folder; `with` closes its port.

    Port 0 is a free port. `origins` are further addresses of the page, such as
    ``https://example.org``; ``null`` is for pages that are opened from files. Raises LipsyncError
    if the folder has no study, or the address cannot be used.
    """

    def __init__(self, folder: Path, host: str, port: int, origins: Collection[str] = ()) -> None:
        refuse_links(folder)
        study = read_study(folder / STUDY_NAME)
        allowed = frozenset(one if one == "null" else origin_of(one) for one in origins)
        log = AnswerLog(folder / ANSWERS, study)
        site = StudySite(_page(folder / PAGE, study), log, allowed)
        self._listener = listening(host, port, MAX_WAITING)
        self.answers = log.path
        self.port: int = self._listener.getsockname()[1]
        config = uvicorn.Config(
            site.app(), http=AnswerConnection, ws="none", lifespan="off", backlog=MAX_WAITING,
            headers=[*RESPONSE_HEADERS.items()], server_header=False, proxy_headers=False,
            # No log receives the address of a rater.
            access_log=False, log_level=logging.CRITICAL,
            timeout_graceful_shutdown=FINISHING_SECONDS,
        )  # fmt: skip
        self._server = uvicorn.Server(config)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()

    def run(self) -> None:
        """Answer requests until the process is interrupted or `stop` is called."""
        self._server.run(sockets=[self._listener])

    def stop(self) -> None:
        """End `run`, which is in another thread."""
        self._server.should_exit = True


def _page(path: Path, study: Study) -> bytes:
    """Return the page with the address of this server for its answers."""
    try:
        content = path.read_bytes()
    except OSError as error:
        what = f"cannot be read: {error.strerror}; make the study again"
        raise LipsyncError(f"{path}: {what}") from None
    if study.study.encode() not in content:
        raise LipsyncError(f"{path}: is the page of another study; make the study again")
    posted = json.dumps(POST_PATH.lstrip("/")).encode()
    # Only the first, at the start of the data: texts of a study may hold the same words.
    return content.replace(UNPOSTED, UNPOSTED.replace(b"null", posted), 1)
