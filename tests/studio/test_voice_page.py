"""The page of a voice: how many pages are heard at once."""

import asyncio
from types import SimpleNamespace

import pytest

pytest.importorskip("starlette")

from lipsync_lang.production.live.web_socket import BUSY, MAX_CLIENTS
from lipsync_lang.studio import voice_page


class Page:
    """A page that is greeted and leaves."""

    def __init__(self):
        self.heard = []

    async def accept(self):
        self.heard.append("accepted")

    async def send_text(self, text):
        self.heard.append(text)

    async def close(self, code, reason):
        self.heard.append((code, reason))

    async def receive(self):
        return {"type": "websocket.disconnect"}


@pytest.mark.parametrize("already", [0, MAX_CLIENTS - 1, MAX_CLIENTS])
def test_a_page_is_heard_unless_too_many_are(already, monkeypatch):
    ended = []
    client = SimpleNamespace(sound=SimpleNamespace(finish=lambda: ended.append(True)))
    monkeypatch.setattr(voice_page, "Client", lambda _: client)
    page, pages = Page(), [Page() for _ in range(already)]
    asyncio.run(voice_page.hear(page, SimpleNamespace(greeting={}), pages))
    assert len(pages) == already
    if already < MAX_CLIENTS:
        assert page.heard == ["accepted", "{}"]
        assert ended
    else:
        assert page.heard == ["accepted", (BUSY, f"{MAX_CLIENTS} clients are connected already")]
