"""Page of a voice: the sound of the browser's microphone comes in, and frames of lips go back."""

import asyncio
import json
from collections.abc import Collection
from contextlib import suppress

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.performer import Performer
from lipsync_lang.production.live.web_socket import BUSY, MAX_CLIENTS, Client, Session
from lipsync_lang.schedules.schedule import AT_REST
from lipsync_lang.studio.face_data import packed_face
from lipsync_lang.studio.module_bundle import bundle
from lipsync_lang.studio.server import MEDIA_TYPES, AsciiResponse, RequestCheck, static_file
from lipsync_lang.studio.take_data import take_data


def voice_app(
    performer: Performer, session: Session, token: str, hosts: Collection[str]
) -> ASGIApp:
    """Return the page of a voice as an ASGI application, with the checks of the studio.

    A character that drives a rig is a `LipsyncError`: the page knows poses alone.
    """
    moving = session.open_gestures() is not None
    pages: list[WebSocket] = []
    document, script = _face_document(performer, gestures=moving), bundle("voice/voice").encode()

    async def data(_: Request) -> Response:
        return AsciiResponse(document)

    async def code(_: Request) -> Response:
        return Response(script, media_type=MEDIA_TYPES[".js"])

    async def page(request: Request) -> Response:
        request.path_params["name"] = "voice/voice.html"
        return await static_file(request)

    async def sound(socket: WebSocket) -> None:
        await hear(socket, session, pages)

    routes = [
        Route("/", page), Route("/face.json", data), Route("/voice.bundle.js", code),
        WebSocketRoute("/sound", sound), Route("/{name:path}", static_file),
    ]  # fmt: skip
    return RequestCheck(Starlette(routes=routes), token, frozenset(hosts))


def _face_document(performer: Performer, *, gestures: bool) -> dict[str, str]:
    """Return the face of a performer at rest as the data of a page, with or without gestures."""
    rest = performer.perform(AT_REST, gestures="all" if gestures else None)
    if performer.rigged(rest) is not rest:
        raise LipsyncError(
            f"the page shows heads whose shapes are poses, and {performer.character} drives a rig; "
            "name another character with -c"
        )
    face, pack = packed_face(rest)
    take = take_data(rest, performer, pack) | {"name": "", "face": 0}
    document = {"takes": [take], "faces": [face], "arrays": pack.layout()}
    return {"document": json.dumps(document), "block": pack.text()}


async def hear(socket: WebSocket, session: Session, pages: list[WebSocket]) -> None:
    """Answer each message of a page until it leaves, unless too many `pages` are heard."""
    await socket.accept()
    if len(pages) >= MAX_CLIENTS:
        await socket.close(BUSY, f"{MAX_CLIENTS} clients are connected already")
        return
    client = Client(session)
    pages.append(socket)
    try:
        with suppress(WebSocketDisconnect):  # before an answer was sent
            await socket.send_text(json.dumps(session.greeting))
            while (message := await socket.receive())["type"] == "websocket.receive":
                content = message.get("bytes") or message.get("text") or ""
                await socket.send_text(json.dumps(await asyncio.to_thread(client.answer, content)))
    finally:
        pages.remove(socket)
        client.sound.finish()
