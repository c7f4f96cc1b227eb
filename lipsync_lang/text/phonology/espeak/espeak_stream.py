"""Speech of many texts by one eSpeak NG process, which forks a process for each text.

The worker loads the library and the voice once, and is forked for each text. The answers are those
of `EspeakProcess.ask`, byte for byte, and a text that crashes or hangs takes no other along. If the
worker itself is lost, the text at hand is spoken by `ask`, and a new worker speaks the rest.
"""

import atexit
import json
import os
import selectors
import signal
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, suppress
from io import FileIO
from subprocess import PIPE
from typing import IO, Any

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.text.phonology.espeak.process import (
    Bytes,
    EspeakProcess,
    ending,
    last_line,
    read_frame,
    refusal,
    unfinished,
)

TEXTS_AHEAD = 8
"""Maximum number of texts sent before their answers are read, so that neither side waits."""

SENT_BYTES = 4096
"""Maximum bytes sent ahead. A pipe holds more on all systems, so sending never blocks."""

PIPE_BYTES = 1 << 20
"""Size asked for the pipe of sounds, so that a forked process writes its sound and ends."""

READ_BYTES = 1 << 30
"""Maximum bytes of a sound, 6 hours of speech; a worker that announces more sends garbage."""

FORKS = hasattr(os, "fork") and sys.platform != "darwin"
"""True if the system can fork a process that has loaded libraries: Windows and macOS cannot."""

WorkerReply = tuple[Any, Bytes]
"""Header and sound."""

IDLE: "dict[tuple[object, ...], _WorkerStream]" = {}
"""The worker of the last texts, which waits for more: a build speaks its lines in batches."""


class _WorkerLostError(Exception):
    """The worker ended, hung or sent garbage while a text was spoken."""


def answers(
    process: EspeakProcess, texts: Iterable[str], voice: str, rate: int
) -> Iterator[WorkerReply | SpeechError]:
    """Speak texts one after the other; yield the answer to each, or its error, in order.

    At most `TEXTS_AHEAD` texts are taken ahead of the answers. If no worker can be started, all
    remaining texts have its error.
    """
    source = iter(texts)
    waiting = deque([text for text in [next(source, None)] if text is not None])
    known = (*vars(process).values(), voice, rate)
    while waiting:
        try:
            stream = IDLE.pop(known, None) or _WorkerStream(process, voice, rate, waiting[0])
        except SpeechError as error:
            yield from (error for _ in waiting)
            yield from (error for _ in source)
            return
        with ExitStack() as stack:
            stack.callback(stream.close)
            try:
                yield from stream.answers(source, waiting)
            except _WorkerLostError:
                try:
                    yield process.ask("speak", text=waiting.popleft(), voice=voice, rate=rate)
                except SpeechError as error:
                    yield error
            else:
                stack.pop_all()
                close_idle()  # of another voice
                IDLE[known] = stream


@atexit.register
def close_idle() -> None:
    """End the worker that waits for further texts."""
    for known in [*IDLE]:
        if stream := IDLE.pop(known, None):  # another thread may have taken it
            stream.close()


if FORKS:  # a forked process would share the pipes of its parent's worker
    os.register_at_fork(after_in_child=IDLE.clear)


class _WorkerStream:
    """A worker that is ready for texts; `close` ends it.

    `SpeechError` tells that the library, its data or the voice is missing, or that none started.
    """

    def __init__(self, process: EspeakProcess, voice: str, rate: int, first: str) -> None:
        self.process, self.voice = process, voice
        self.sizes: deque[int] = deque()
        """Size in bytes of each text that was sent and has no answer."""
        request, folder = process.request("speak_many", voice=voice, rate=rate)
        # No pipe: nobody would read it, and a full one stops the worker.
        self.printed: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 closed with the stream
        try:
            self.worker = subprocess.Popen(  # noqa: S603 our own script, no shell
                process.command, stdin=PIPE, stdout=PIPE, stderr=self.printed, cwd=folder, bufsize=0
            )
        except OSError as error:
            self.printed.close()
            raise process.unstarted(error) from None
        assert self.worker.stdin is not None  # noqa: S101 for the type checker
        assert isinstance(self.worker.stdout, FileIO)  # noqa: S101
        self.requests, self.replies = self.worker.stdin, self.worker.stdout
        with suppress(ImportError, AttributeError, OSError):  # only Linux, within the user's quota
            import fcntl

            fcntl.fcntl(self.replies, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        self.ready = selectors.DefaultSelector()
        self.ready.register(self.replies, selectors.EVENT_READ)
        try:
            self._begin(request, first)
        # Also if the user interrupts: the worker must not outlive its stream.
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """End the worker; its forked processes end at their next write or their limit."""
        self.worker.kill()
        self.worker.wait()
        self.ready.close()
        self.requests.close()
        self.replies.close()
        self.printed.close()

    def _begin(self, request: dict[str, Any], first: str) -> None:
        """Send the request, and wait until the worker is ready for texts."""
        try:
            self._write(request)
            header, _ = self._frame(self.process.patience)
        except _WorkerLostError:
            late = self.worker.poll() is None and not self.ready.select(0)
            self.worker.kill()
            code = self.worker.wait()
            self.printed.seek(0)
            crashed = ending(code, self.printed.read(), first, self.voice)
            slow = unfinished(self.process.patience, first)
            raise SpeechError(slow if late else crashed) from None
        if "rate" not in header:
            raise SpeechError(refusal(header, self.voice))

    def answers(
        self, source: Iterator[str], waiting: deque[str]
    ) -> Iterator[WorkerReply | SpeechError]:
        """Yield the answer to each text; `waiting` holds the texts that were taken ahead."""
        while True:
            self._send(source, waiting)
            if not waiting:
                return
            answer = self._answer(waiting[0])
            waiting.popleft()
            self.sizes.popleft()
            yield answer

    def _send(self, source: Iterator[str], waiting: deque[str]) -> None:
        """Send texts ahead. A long one waits until the worker reads, so only one side writes."""
        while True:
            if len(self.sizes) == len(waiting):
                text = next(source, None) if len(waiting) < TEXTS_AHEAD else None
                if text is None:
                    return
                waiting.append(text)
            text = waiting[len(self.sizes)]
            size = len(json.dumps(text))
            if self.sizes and sum(self.sizes) + size > SENT_BYTES:
                return
            self._write((text, self.process.limit([text])))
            self.sizes.append(size)

    def _answer(self, text: str) -> WorkerReply | SpeechError:
        """Read the frames of a text: that of speech, if there is one, and that of its end."""
        seconds = self.process.limit([text])
        # The alarm of the worker rings first, and costs this text alone.
        header, sound = self._frame(2 * seconds)
        end = header if "code" in header else self._frame(seconds)[0]
        said = str(end.get("said", "")).encode()
        match end.get("code"):
            case 0 if end is not header:
                pass
            case int(code) if code == -getattr(signal, "SIGALRM", 0) != 0:
                return SpeechError(unfinished(seconds, text))
            case int(code):
                return SpeechError(ending(code, said, text, self.voice))
            case _:
                raise _WorkerLostError
        if "error" in header:
            return SpeechError(refusal(header, self.voice))
        return header | {"said": last_line(said)}, sound

    def _write(self, request: object) -> None:
        line = json.dumps(request).encode("ascii") + b"\n"
        try:
            while line:
                # A pipe without a buffer may take a part.
                line = line[self.requests.write(line) or 0 :]
        except OSError:
            raise _WorkerLostError from None

    def _frame(self, seconds: float) -> WorkerReply:
        """Read a frame within some seconds."""
        deadline = time.monotonic() + seconds
        try:
            return read_frame(lambda size: self._read(size, deadline))
        except SpeechError:
            raise _WorkerLostError from None

    def _read(self, size: int, deadline: float) -> bytearray:
        """Read a number of bytes; fewer at the end or at the deadline."""
        read, count = bytearray(min(size, READ_BYTES)), 0
        while count < len(read) and self.ready.select(max(deadline - time.monotonic(), 0.0)):
            part = self.replies.readinto(memoryview(read)[count:])
            if not part:
                break
            count += part
        return read if count == len(read) else read[:count]
