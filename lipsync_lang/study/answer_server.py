"""Server of a study: serves only its page, and stores answers.

Answers are checked, appended to one file and never changed. Every request has a deadline and a
maximum size, and requests from other sites are refused.
"""

import json
import os
import time
from collections import deque
from collections.abc import Collection
from hashlib import blake2b
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from ipaddress import ip_address
from pathlib import Path
from socket import AF_INET6, SHUT_RD
from threading import BoundedSemaphore, Lock, Timer
from typing import Any
from urllib.parse import urlsplit

from lipsync_lang.errors import LipsyncError
from lipsync_lang.study.study_file import (
    MAX_ANSWERS_BYTES,
    MAX_SUBMISSION_BYTES,
    Study,
    Submission,
    as_text,
    faults_against,
    parsed,
    read_study,
)
from lipsync_lang.study.study_maker import KEY, PAGE
from lipsync_lang.study.study_page import UNPOSTED, origin_of

ANSWERS = "answers.jsonl"
"""Name of the file of answers."""

POST_PATH = "/answers"
"""Path to which pages post answers."""

REQUEST_SECONDS = 30.0
"""Time limit for the arrival of a request."""

SEND_SECONDS = 60.0
"""Time limit for a client that takes no byte of a response."""

MAX_CONNECTIONS = 64
"""Maximum number of simultaneous connections."""

MAX_PER_MINUTE = 60
"""Maximum number of submissions per minute and address; a laboratory shares one address."""

MAX_MAP = 10_000
"""Maximum number of addresses in memory."""

MAX_PORT = 65535

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cache-Control": "no-store",
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
        self._known = self._lines()

    def _lines(self) -> set[bytes]:
        """Return the digests of the lines in the file."""
        try:
            content = self.path.read_bytes()
        except FileNotFoundError:
            return set()
        except OSError as error:
            raise LipsyncError(f"{self.path}: cannot be read: {error.strerror}") from None
        return {_digest(line) for line in content.split(b"\n") if line}

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
        with self._lock:
            return self._append(line)

    def _append(self, line: bytes) -> tuple[HTTPStatus, str]:
        digest = _digest(line.rstrip(b"\n"))
        if digest in self._known:
            return HTTPStatus.OK, ""
        handle = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
        with os.fdopen(handle, "rb+", buffering=0) as file:
            size = file.seek(0, os.SEEK_END)
            if size + len(line) > MAX_ANSWERS_BYTES:
                return HTTPStatus.INSUFFICIENT_STORAGE, "the file of answers is full"
            if size and file.seek(size - 1) and file.read(1) != b"\n":
                line = b"\n" + line  # a write before was cut off
            file.write(line)
            os.fsync(file.fileno())
        self._known.add(digest)
        return HTTPStatus.CREATED, ""


def _digest(line: bytes) -> bytes:
    return blake2b(line, digest_size=16).digest()


class AnswerServer(ThreadingHTTPServer):
    """A server of one study.

    Parameters
    ----------
    page : content of the page, which posts to this server
    log : the file of answers
    origins : further addresses of the page that may send answers
    """

    daemon_threads = True
    block_on_close = False
    request_queue_size = MAX_WAITING

    def __init__(
        self, address: tuple[str, int], page: bytes, log: AnswerLog, origins: frozenset[str]
    ) -> None:
        if ":" in address[0]:
            self.address_family = AF_INET6
        self.page, self.log, self.origins = page, log, origins
        self._room = BoundedSemaphore(MAX_CONNECTIONS)
        self._recent: dict[str, deque[float]] = {}
        self._lock = Lock()
        super().__init__(address, _Handler)

    @property
    def answers(self) -> Path:
        """File of answers."""
        return self.log.path

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection in a thread; drop those beyond `MAX_CONNECTIONS`."""
        if not self._room.acquire(blocking=False):
            self.shutdown_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve a connection, and free its place."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._room.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore broken connections."""

    def hurried(self, address: str) -> bool:
        """Return True if an address has sent too many submissions in the last minute."""
        now = time.monotonic()
        with self._lock:
            if len(self._recent) > MAX_MAP:
                self._recent.clear()
            times = self._recent.setdefault(address, deque())
            while times and times[0] < now - 60:
                times.popleft()
            if len(times) >= MAX_PER_MINUTE:
                return True
            times.append(now)
            return False


class _Handler(BaseHTTPRequestHandler):
    """Handler of one connection: a request and its answer."""

    server: AnswerServer
    server_version, sys_version = "lipsync-lang", ""
    protocol_version = "HTTP/1.0"
    timeout = SEND_SECONDS

    def setup(self) -> None:
        super().setup()
        self._deadline = Timer(REQUEST_SECONDS, self._hang_up)
        self._deadline.daemon = True
        self._deadline.start()

    def finish(self) -> None:
        self._deadline.cancel()
        super().finish()

    def _hang_up(self) -> None:
        """End a request that arrives too slowly."""
        try:
            self.connection.shutdown(SHUT_RD)
        except OSError:
            return

    def log_message(self, *_: object) -> None:
        """Keep addresses of raters out of every log."""

    def do_GET(self) -> None:
        """Send the page."""
        if self._refused() is None and self.path in {"/", f"/{PAGE}"}:
            self._answer(HTTPStatus.OK, self.server.page, "text/html; charset=utf-8")
        else:
            self._tell(*(self._refused() or (HTTPStatus.NOT_FOUND, "there is no such page")))

    do_HEAD = do_GET  # noqa: N815 named by http.server

    def do_OPTIONS(self) -> None:
        """Allow a page of a permitted origin to post."""
        if self._refused() is None and self.path == POST_PATH:
            self._answer(HTTPStatus.NO_CONTENT, b"", "text/plain")
        else:
            self._tell(HTTPStatus.FORBIDDEN, "requests from other sites are refused")

    def do_POST(self) -> None:
        """Store answers."""
        refused = self._refused() or self._unfit()
        if refused is not None:
            self._tell(*refused)
            return
        size = int(self.headers["Content-Length"])
        content = self.rfile.read(size)
        if len(content) < size:
            self._tell(HTTPStatus.REQUEST_TIMEOUT, "the answers did not arrive in full")
        elif self.server.hurried(str(self.client_address[0])):
            self._tell(HTTPStatus.TOO_MANY_REQUESTS, "too many answers; wait a minute")
        else:
            self._take(content)

    def _take(self, content: bytes) -> None:
        try:
            self._tell(*self.server.log.add(content))
        except OSError:
            self._tell(HTTPStatus.INSUFFICIENT_STORAGE, "the answers cannot be stored")

    def _refused(self) -> tuple[HTTPStatus, str] | None:
        """Return the refusal of a request from another site; None for other requests."""
        host = self.headers.get("Host", "")
        origin = self.headers.get("Origin")
        hosts = {urlsplit(one).netloc for one in self.server.origins} - {""}
        if not (_is_numeric(host) or host in hosts):
            return HTTPStatus.MISDIRECTED_REQUEST, "this address is not that of the study"
        own = {f"http://{host}", *self.server.origins}
        if origin is not None and origin not in own:
            return HTTPStatus.FORBIDDEN, "requests from other sites are refused"
        return None

    def _unfit(self) -> tuple[HTTPStatus, str] | None:
        """Return the refusal of a post that cannot be a submission; None for other posts."""
        length = self.headers.get("Content-Length", "")
        kind = self.headers.get_content_type()
        if self.path != POST_PATH:
            return HTTPStatus.NOT_FOUND, "there is no such page"
        if kind != "application/json":
            return HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "send the answers as application/json"
        if not (length.isascii() and length.isdecimal()):
            return HTTPStatus.LENGTH_REQUIRED, "the header Content-Length is missing"
        if len(length) > len(str(MAX_SUBMISSION_BYTES)) or int(length) > MAX_SUBMISSION_BYTES:
            return HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "the answers are too long"
        return None

    def _tell(self, status: HTTPStatus, fault: str) -> None:
        told = {"error": fault} if fault else {"taken": True}
        self._answer(status, json.dumps(told).encode(), "application/json")

    def _answer(self, status: HTTPStatus, content: bytes, kind: str) -> None:
        self._deadline.cancel()
        self.send_response(status)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        origin = self.headers.get("Origin") if self.headers else None
        if origin in self.server.origins:
            self.send_header("Access-Control-Allow-Origin", str(origin))
            self.send_header("Access-Control-Allow-Headers", "content-type")
            self.send_header("Vary", "Origin")
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)


def _is_numeric(host: str) -> bool:
    """Return True for numeric addresses and localhost, which no other site can take over."""
    try:
        name = urlsplit(f"//{host}").hostname or ""
        return name == "localhost" or bool(ip_address(name))
    except ValueError:
        return False


def answer_server(
    folder: Path, host: str, port: int, origins: Collection[str] = ()
) -> AnswerServer:
    """Return a server of the study in a folder; `serve_forever` runs it.

    Parameters
    ----------
    host, port : address of the server; port 0 for a free port
    origins : further addresses of the page, such as ``https://example.org``; ``null`` for pages
        that are opened from files

    Raises
    ------
    LipsyncError
        The folder has no study, or the address cannot be used.
    """
    study = read_study(folder / KEY)
    allowed = frozenset(one if one == "null" else origin_of(one) for one in origins)
    log = AnswerLog(folder / ANSWERS, study)
    if not 0 <= port <= MAX_PORT:
        raise LipsyncError(f"port {port}: give a number from 1 to {MAX_PORT}, or 0 for a free port")
    try:
        return AnswerServer((host, port), _page(folder / PAGE, study), log, allowed)
    except OSError as error:
        raise LipsyncError(
            f"{host}, port {port}: cannot be used: {error}; "
            "choose another port, or 0 for a free port"
        ) from None


def _page(path: Path, study: Study) -> bytes:
    """Return the page with the address of this server for its answers."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise LipsyncError(
            f"{path}: cannot be read: {error.strerror}; make the study again"
        ) from None
    if study.study.encode() not in content:
        raise LipsyncError(f"{path}: is the page of another study; make the study again")
    posted = json.dumps(POST_PATH.lstrip("/")).encode()
    return content.replace(UNPOSTED, UNPOSTED.replace(b"null", posted), 1)
