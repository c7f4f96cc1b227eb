"""Requests to the studio's server without a socket."""

import asyncio
import json
from typing import NamedTuple
from urllib.parse import urlencode

from lipsync_lang.studio.server import app

TOKEN = "a-token-for-tests"  # noqa: S105 of a server that nobody else reaches
HOST = "127.0.0.1:8000"


class Answered(NamedTuple):
    status: int
    headers: dict
    content: bytes

    @property
    def json(self):
        return json.loads(self.content)


class Caller:
    """A browser that asks a workshop."""

    def __init__(self, workshop):
        self.app = app(workshop, TOKEN, [HOST])

    def get(self, path, **headers):
        return self.ask("GET", f"/{TOKEN}/{path}", b"", headers)

    def post(self, path, body=None, query=(), **headers):
        content = body if isinstance(body, bytes) else json.dumps(body or {}).encode()
        return self.ask("POST", f"/{TOKEN}/api/{path}", content, headers, dict(query))

    def api(self, path):
        return self.get(f"api/{path}")

    def ask(self, method, path, content=b"", headers=(), query=()):
        stated = {"host": HOST, "content-length": str(len(content))} | dict(headers)
        scope = {
            "type": "http", "asgi": {"version": "3.0"}, "http_version": "1.1", "method": method,
            "scheme": "http", "path": path, "root_path": "",
            "raw_path": path.encode("utf-8", "replace"),
            "query_string": urlencode(query).encode(), "client": None, "server": None,
            "headers": [(k.replace("_", "-").encode(), v.encode()) for k, v in stated.items()],
        }  # fmt: skip
        messages = []

        async def receive():
            return {"type": "http.request", "body": content, "more_body": False}

        async def send(message):
            messages.append(message)

        asyncio.run(self.app(scope, receive, send))
        start = next(m for m in messages if m["type"] == "http.response.start")
        heads = {k.decode().lower(): v.decode() for k, v in start["headers"]}
        return Answered(start["status"], heads, b"".join(m.get("body", b"") for m in messages))


def unpacked(answer):
    """Return the document of an answer with arrays, and the number of bytes after it."""
    length = int.from_bytes(answer.content[:4], "little")
    document = json.loads(answer.content[4 : 4 + length])
    return document, len(answer.content) - 4 - length
