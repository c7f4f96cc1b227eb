"""Messages from WebSocket clients: a text to speak, or timed phonemes to animate.

A message is a JSON object with one of these:

- `text`: a text to speak for all receivers, after the texts before it;
- `phonemes`: rows of label, start and end in seconds (null while it lasts), `known_until`, `revise`
  and `finish: true`, for a stream of this client. The answer contains its new final frames;
  the next message after `finish` opens a new stream.

The answer to a message that cannot be read is `error`, and the message has no other effect.
"""

import json
from collections.abc import Callable
from typing import Any

from lipsync_lang.errors import LipsyncError
from lipsync_lang.live.outlets import LiveFrame, as_row
from lipsync_lang.performing.stream import Stream

MAX_MESSAGE_BYTES = 64 * 1024
"""Maximum size of a message: some thousand phonemes, or a page of text."""

MAX_PHONEME_ROWS = 2000
"""Maximum number of phonemes in a message."""

MAX_OWN_SECONDS = 600.0
"""Longest phoneme or pause from a client: a message cannot request an hour of frames."""

FIELDS = ("text", "phonemes", "known_until", "revise", "finish", "notation")

ROW = len(("label", "start", "end"))


class Client:
    """A client of a live session.

    Parameters
    ----------
    say : queues a text for all receivers; returns the number of texts before it
    open_stream : opens a stream in a notation; None stands for the language's own
    """

    def __init__(
        self, say: Callable[[str], int], open_stream: Callable[[str | None], Stream]
    ) -> None:
        self.say, self.open_stream = say, open_stream
        self.stream: Stream | None = None

    def answer(self, message: str | bytes) -> dict[str, Any]:
        """Carry out the request of a message, and return the answer."""
        try:
            asked = json.loads(message)
        except (ValueError, RecursionError):
            return {"error": 'the message is not JSON; send an object such as {"text": "Hello"}'}
        if not isinstance(asked, dict):
            return {"error": 'the message is not a JSON object; send one such as {"text": "Hello"}'}
        try:
            return self._answer(asked)
        except LipsyncError as error:
            return {"error": str(error)}

    def _answer(self, asked: dict[str, Any]) -> dict[str, Any]:
        unknown = [name for name in asked if name not in FIELDS]
        if unknown or not asked:
            raise LipsyncError(
                (f"unknown field '{unknown[0][:40]}'; " if unknown else "the message is empty; ")
                + f"the fields of a message are {', '.join(FIELDS)}"
            )
        if "text" in asked:
            text = asked["text"]
            if not isinstance(text, str) or len(asked) > 1:
                raise LipsyncError(
                    '`text` must be a string, and the only field of its message: {"text": "Hello"}'
                )
            return {"waiting": self.say(text)}
        if self.stream is None:
            notation = asked.get("notation")
            if notation is not None and not isinstance(notation, str):
                raise LipsyncError(
                    "`notation` must be a string: the name of a notation of the language"
                )
            self.stream = self.open_stream(notation)
        return self._feed(self.stream, asked)

    def _feed(self, stream: Stream, asked: dict[str, Any]) -> dict[str, Any]:
        if "revise" in asked:
            stream.revise(asked["revise"])
        # All rows are checked for their form before the first is fed; the stream checks times.
        rows = asked.get("phonemes", [])
        if not isinstance(rows, list) or len(rows) > MAX_PHONEME_ROWS:
            raise LipsyncError(
                f"`phonemes` must be a list of at most {MAX_PHONEME_ROWS} rows of label, start "
                "and end"
            )
        if any(not isinstance(row, list) or len(row) != ROW for row in rows):
            raise LipsyncError(
                "each row of `phonemes` must be a label, a start and an end, "
                'such as ["LABEL", 0.1, 0.25]'
            )
        for label, start, end in rows:
            _refuse_long(stream, start if end is None else end)
            stream.feed(label, start, end)
        if "known_until" in asked:
            _refuse_long(stream, asked["known_until"])
            stream.known_until(asked["known_until"])
        if asked.get("finish"):
            stream.finish()
        final = stream.frames()
        frames = map(as_row, map(LiveFrame, final.times.tolist(), final.weights))
        answer = {"frames": [*frames], "known": stream.known}
        if stream.finished:
            self.stream = None
        return answer


def _refuse_long(stream: Stream, seconds: object) -> None:
    known = stream.known
    if known is None or isinstance(seconds, bool) or not isinstance(seconds, (int, float)):
        return
    if seconds - known > MAX_OWN_SECONDS:
        raise LipsyncError(
            f"{known:g} to {seconds:g} s is longer than {MAX_OWN_SECONDS:g} s; "
            "give times in seconds, and send long pauses in parts"
        )
