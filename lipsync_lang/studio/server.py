"""Server of the studio: its address, its guard, its files and its routes.

The address contains a random token. A page of another site cannot guess it, and cannot use it with
another `Host` or `Origin`. Every response forbids scripts, styles and requests of other sites.
"""

import gzip
import json
import logging
from collections.abc import Callable, Collection
from functools import cache
from importlib import import_module
from importlib.resources import files
from secrets import compare_digest
from threading import Lock, Thread
from typing import Any
from urllib.parse import urlsplit

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, RedirectResponse, Response
from starlette.routing import Route as WebRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.studio.merging import EditConflict
from lipsync_lang.studio.module_bundle import bundle
from lipsync_lang.studio.routes.asking import Answer, Packed, Refused, Route, Wish
from lipsync_lang.studio.workshop import Workshop

_log = logging.getLogger(__name__)

VIEWS = (
    "project_routes",
    "line_routes",
    "script_routes",
    "sentence_routes",
    "bigram_routes",
    "character_routes",
    "language_routes",
    "coverage_routes",
    "words_routes",
)
"""Names of modules of `routes`."""

MAX_REQUEST_BYTES = 64 * 2**20
"""Maximum size of a request: a recording of some minutes."""

SCRIPT = "studio.bundle.js"
"""Name of the script that `studio.html` loads."""

KINDS = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "json": "application/json",
}
"""Media types of files, by suffix."""

HEADERS = {
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


def app(workshop: Workshop, token: str, hosts: Collection[str]) -> ASGIApp:
    """Return the studio as an ASGI application.

    Parameters
    ----------
    workshop : the pair and the line
    token : secret part of the address
    hosts : accepted values of the `Host` header, such as ``127.0.0.1:8765``
    """
    lock = Lock()
    Thread(target=_script, daemon=True).start()  # ready by the time a browser asks
    routes = [WebRoute("/", _file("studio.html")), WebRoute("/{name}", _named)]
    for view in VIEWS:
        table = import_module(f"lipsync_lang.studio.routes.{view}").ROUTES
        for path, route in table.items():
            method, _, where = path.partition(" ")
            where = where.replace("{name}", "{name:path}")
            routes.append(
                WebRoute(f"/api/{where}", _asking(workshop, route, lock), methods=[method])
            )
    return Guard(Starlette(routes=routes), token, frozenset(hosts))


class Guard:
    """Refuses requests without the token, from other sites, or of too many bytes."""

    def __init__(self, inner: ASGIApp, token: str, hosts: frozenset[str]) -> None:
        self.inner, self.token, self.hosts = inner, token, hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] != "http":
            return
        headers = {key.decode("latin-1"): v.decode("latin-1") for key, v in scope["headers"]}
        refused = self._refusal(scope["path"], headers)

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                own = [(k.encode(), v.encode()) for k, v in HEADERS.items()]
                message = {**message, "headers": [*message["headers"], *own]}
            await send(message)

        answer: ASGIApp
        if refused is not None:
            answer = refused
        elif scope["path"] == f"/{self.token}":
            answer = RedirectResponse(f"/{self.token}/")
        else:
            answer = self.inner
            start = scope["path"].removeprefix(f"/{self.token}")
            scope = {**scope, "path": start, "raw_path": start.encode()}
        await answer(scope, _limited(receive), guarded)

    def _refusal(self, path: str, headers: dict[str, str]) -> Response | None:
        """Return the response to a refused request; None for other requests."""
        origin = headers.get("origin")
        if headers.get("host") not in self.hosts:
            return _error(
                421,
                "this address is not that of the studio; use the address that the studio printed",
            )
        if origin is not None and urlsplit(origin).netloc not in self.hosts:
            return _error(403, "requests from other sites are refused")
        if headers.get("sec-fetch-site", "none") not in {"none", "same-origin"}:
            return _error(403, "requests from other sites are refused")
        token = path.split("/", 2)[1] if path.startswith("/") else ""
        if not compare_digest(token.encode(), self.token.encode()):
            return _error(
                404, "there is no such page; use the whole address that the studio printed"
            )
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > MAX_REQUEST_BYTES:
            return _error(413, f"the request is larger than {MAX_REQUEST_BYTES >> 20} MB")
        return None


class _TooLargeError(Exception):
    """A request without a stated length exceeds the limit."""


def _limited(receive: Receive) -> Receive:
    seen = 0

    async def limited() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > MAX_REQUEST_BYTES:
            raise _TooLargeError
        return message

    return limited


def _asking(workshop: Workshop, route: Route, lock: Lock) -> Callable[[Request], Any]:
    """Return the endpoint of a route; requests are answered one at a time."""

    def call(asked: Wish) -> Answer:
        with lock:
            return route(workshop, asked)

    async def endpoint(request: Request) -> Response:
        try:
            content = await request.body()
            asked = Wish(request.path_params.get("name", ""), dict(request.query_params), content)
            answer = await run_in_threadpool(call, asked)
        except (_TooLargeError, ClientDisconnect):
            return _error(413, f"the request is larger than {MAX_REQUEST_BYTES >> 20} MB")
        except LipsyncError as error:
            return _told(error)
        except Exception:  # noqa: BLE001 no traceback reaches a user; the log has it
            _log.exception("%s failed", request.url.path)
            return _error(
                500, "the studio has failed; see its terminal for details. No edits are lost"
            )
        if isinstance(answer, Packed):
            return Response(answer.content(), media_type="application/octet-stream")
        return JSONResponse(answer)

    return endpoint


def _told(error: LipsyncError) -> Response:
    """Return an error as JSON: its message, its faults, and the entries of a conflict."""
    told: dict[str, Any] = {"error": str(error)}
    if isinstance(error, PackFaults):
        told["faults"] = [
            {
                "place": f"{f.file}:{f.line}:{f.column}",
                "code": f.code,
                "what": f.what,
                "hint": f.hint,
            }
            for f in error.faults
        ]
    if isinstance(error, Refused):
        return JSONResponse(told | {"conflict": error.conflict}, 409)
    return JSONResponse(told, 409 if isinstance(error, EditConflict) else 422)


def _error(status: int, what: str) -> Response:
    return Response(json.dumps({"error": what}), status, media_type="application/json")


def _file(name: str) -> Callable[[Request], Any]:
    async def endpoint(_: Request) -> Response:
        kind = KINDS[name.rpartition(".")[2]]
        content = (files("lipsync_lang.studio") / "static" / name).read_bytes()
        return Response(content, media_type=kind)

    return endpoint


@cache
def _script() -> bytes:
    """Return the studio's modules as one compressed script, for a single small request."""
    return gzip.compress(bundle("studio").encode(), mtime=0)


async def _named(request: Request) -> Response:
    """Serve a file of `static`; the route excludes names with folders."""
    name = request.path_params["name"]
    if name == SCRIPT:
        return Response(_script(), headers={"content-encoding": "gzip"}, media_type=KINDS["js"])
    known = {one.name for one in (files("lipsync_lang.studio") / "static").iterdir()}
    if name not in known or name.rpartition(".")[2] not in KINDS:
        return _error(404, "there is no such file")
    answer: Response = await _file(name)(request)
    return answer
