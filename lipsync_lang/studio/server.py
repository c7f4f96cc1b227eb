"""Server of the studio: its address, its checks of requests, its files and its routes.

The address contains a random token. A page of another site cannot guess it, and cannot use it with
another `Host` or `Origin`. Every response forbids scripts, styles and requests of other sites.

A page whose server has ended sends the token to no server that does not prove first that it knows
it: by the HMAC of a text of the page.
"""

import gzip
import hmac
import json
import logging
from collections.abc import Callable, Collection, Mapping
from functools import cache
from pathlib import Path
from secrets import compare_digest, token_hex
from threading import Lock, Thread
from typing import Any
from urllib.parse import urlsplit

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, RedirectResponse, Response
from starlette.routing import Route as WebRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.studio.merging import EditConflict
from lipsync_lang.studio.module_bundle import bundle
from lipsync_lang.studio.routes.requests import (
    PackedResponse,
    Route,
    RouteResult,
    StudioRequest,
    UnresolvedConflict,
)
from lipsync_lang.studio.routes.table import ROUTES
from lipsync_lang.studio.workshop import Workshop

_log = logging.getLogger(__name__)

MAX_REQUEST_BYTES = 64 * 2**20
"""Maximum size of a request: a recording of some minutes."""

PROOF = "/proof/"
"""Start of the path at which a server proves that it knows the token; the rest is any text."""

MAX_PROVED_CHARS = 100
"""Maximum length of a text to prove."""

STUDIO_SCRIPT = "studio.bundle.js"
"""Name of the script that `studio.html` loads."""

MEDIA_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
}
"""Media types of files, by suffix; the registry of Windows can have others."""

SECURITY_HEADERS = {
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src 'self' data: blob:; media-src blob:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
"""Headers of every response."""


def _host_of(origin: str) -> str:
    """Return the host and port of an `Origin`; empty for text that is none."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return ""


def app(workshop: Workshop, token: str, hosts: Collection[str]) -> ASGIApp:
    """Return the studio as an ASGI application.

    `token` is the secret part of the address, and `hosts` are the accepted values of the `Host`
    header, such as ``127.0.0.1:8765``.
    """
    # A workshop is not made for several threads, and Starlette answers in a pool of them.
    lock = Lock()
    Thread(target=_script, daemon=True).start()  # ready by the time a browser asks
    routes = []
    for path, route in ROUTES.items():
        method, _, where = path.replace("{name}", "{name:path}").partition(" ")
        endpoint = _endpoint(workshop, route, lock)
        routes.append(WebRoute(f"/api/{where}", endpoint, methods=[method]))
    routes += [WebRoute("/", static_file), WebRoute("/{name:path}", static_file)]
    return RequestCheck(Starlette(routes=routes), token, frozenset(hosts))


class RequestCheck:
    """Refuses requests without the token, from other sites, or of too many bytes."""

    def __init__(self, inner: ASGIApp, token: str, hosts: frozenset[str]) -> None:
        self.inner, self.token, self.hosts = inner, token, hosts
        # By its name, a page notices that a studio was started again while it asked for nothing.
        self.headers = {**SECURITY_HEADERS, "x-studio": token_hex(8)}
        # Other machines could try tokens that a person chose against a proof.
        self.proves = any(host.startswith("127.0.0.1:") for host in hosts)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] not in ("http", "websocket"):
            return
        headers = {key.decode("latin-1"): v.decode("latin-1") for key, v in scope["headers"]}
        refused = self._refusal(scope["path"], headers)

        async def send_secured(message: Message) -> None:
            if message["type"] == "http.response.start":
                own = [(k.encode(), v.encode()) for k, v in self.headers.items()]
                message = {**message, "headers": [*message["headers"], *own]}
            await send(message)

        if refused is not None and scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
            return
        answer: ASGIApp
        if refused is not None:
            answer = refused
        elif scope["path"] == f"/{self.token}":
            answer = RedirectResponse(f"/{self.token}/")
        else:
            answer = self.inner
            start = scope["path"].removeprefix(f"/{self.token}")
            scope = {**scope, "path": start, "raw_path": start.encode("utf-8", "replace")}
        await answer(scope, receive, send_secured)

    def _refusal(self, path: str, headers: dict[str, str]) -> Response | None:
        """Return the response to a refused request; None for other requests."""
        if headers.get("host") not in self.hosts:
            return _error(421, "this is not the address of the studio; use the one that it printed")
        origin, site = headers.get("origin"), headers.get("sec-fetch-site", "none")
        foreign = origin is not None and _host_of(origin) not in self.hosts
        # Old browsers send no `Sec-Fetch-Site`, and some requests have no `Origin`: each has a say.
        if foreign or site not in {"none", "same-origin"}:
            return _error(403, "requests from other sites are refused")
        if path.startswith(PROOF) and self.proves:
            text = path.removeprefix(PROOF)[:MAX_PROVED_CHARS]
            return Response(hmac.digest(self.token.encode(), text.encode(), "sha256"))
        token = path.split("/", 2)[1] if path.startswith("/") else ""
        # In constant time, so that nobody finds the token letter by letter.
        if not compare_digest(token.encode(), self.token.encode()):
            return _error(404, "there is no such page; use the whole address of the studio")
        length = headers.get("content-length", "0")
        large = not length.isdecimal() or int(length) > MAX_REQUEST_BYTES
        return _too_large() if large else None


class AsciiResponse(JSONResponse):
    """JSON in ASCII, since files of timings may hold text that is no Unicode."""

    def render(self, content: object) -> bytes:
        """Return the JSON."""
        return json.dumps(content, allow_nan=False, separators=(",", ":")).encode()


def _endpoint(workshop: Workshop, route: Route, lock: Lock) -> Callable[[Request], Any]:
    """Return the endpoint of a route; requests are answered one at a time."""

    def call(asked: StudioRequest) -> RouteResult:
        with lock:
            return route(workshop, asked)

    async def endpoint(request: Request) -> Response:
        content = bytearray()
        try:
            async for chunk in request.stream():  # a request without a stated length has no end
                content += chunk
                if len(content) > MAX_REQUEST_BYTES:
                    return _too_large()
            name, query = request.path_params.get("name", ""), dict(request.query_params)
            answer = await run_in_threadpool(call, StudioRequest(name, query, bytes(content)))
        except ClientDisconnect:
            return _too_large()
        except LipsyncError as error:
            return _error_response(error)
        except Exception as error:  # noqa: BLE001 no traceback reaches a user; the log has it
            _log.exception("%s failed", request.url.path)
            told = "the studio has failed; see its terminal for details"
            if isinstance(error, OSError):  # such as a full disk
                told = f"{error.filename or 'a file'}: {error.strerror or error}; mend that first"
            return _error(500, f"{told}. No edits are lost")
        if isinstance(answer, PackedResponse):
            return Response(answer.content(), media_type="application/octet-stream")
        return AsciiResponse(answer)

    return endpoint


def _error_response(error: LipsyncError) -> Response:
    """Return an error as JSON: its message, its faults, and the entries of a conflict."""
    data: dict[str, object] = {"error": str(error)}
    if isinstance(error, PackFaults):
        data["faults"] = [
            {"place": f"{one.file}:{one.line}:{one.column}", "code": one.code}
            | {"what": one.what, "hint": one.hint}
            for one in error.faults
        ]
    if isinstance(error, UnresolvedConflict):
        return AsciiResponse(data | {"conflict": error.conflict}, 409)
    return AsciiResponse(data, 409 if isinstance(error, EditConflict) else 422)


def _error(status: int, what: str) -> Response:
    return AsciiResponse({"error": what}, status)


def _too_large() -> Response:
    return _error(413, f"the request is larger than {MAX_REQUEST_BYTES >> 20} MB")


async def static_file(request: Request) -> Response:
    """Serve a file of `static`, or the studio's script."""
    name = request.path_params.get("name", "studio.html")
    if name == STUDIO_SCRIPT:
        return Response(
            _script(), headers={"content-encoding": "gzip"}, media_type=MEDIA_TYPES[".js"]
        )
    file = _static_files().get(name)
    if file is None:
        return _error(404, "there is no such file")
    return Response(file.read_bytes(), media_type=MEDIA_TYPES[file.suffix])


@cache
def _script() -> bytes:
    """Return the studio's modules as one compressed script, for a single small request."""
    return gzip.compress(bundle("shell/studio").encode(), mtime=0)


@cache
def _static_files() -> Mapping[str, Path]:
    """Return the files of `static` by their paths, so that a request can name no other file."""
    folder = Path(__file__).parent / "static"
    return {
        file.relative_to(folder).as_posix(): file
        for file in folder.rglob("*")
        if file.suffix in MEDIA_TYPES
    }
