"""Text speaker: a thread speaks texts sentence by sentence, in the order of their arrival."""

import re
from collections.abc import Callable
from queue import SimpleQueue
from threading import Lock, Thread
from typing import TYPE_CHECKING

from lipsync_lang.errors import LipsyncError

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Schedule

SENTENCE_END = re.compile(r"(?<=[.!?…।؟])\s+|(?<=[。！？])")
"""Ends of sentences: the first sentence plays while the next ones are synthesised."""

MAX_WAITING_TEXTS = 100

MAX_SPOKEN_CHARS = 20_000


class TextSpeaker:
    """Turns texts into schedules.

    Parameters
    ----------
    speak : speaks a text
    say : takes each schedule
    complain : takes the message about a text that cannot be spoken
    """

    def __init__(
        self,
        speak: "Callable[[str], Schedule]",
        say: "Callable[[Schedule], object]",
        complain: Callable[[str], None],
    ) -> None:
        self.speak, self.perform, self.complain = speak, say, complain
        self.texts: SimpleQueue[str] = SimpleQueue()
        self.lock, self.pending = Lock(), 0
        Thread(target=self._work, daemon=True).start()

    @property
    def busy(self) -> bool:
        """True while a text waits or is being spoken."""
        with self.lock:
            return self.pending > 0

    def say(self, text: str) -> int:
        """Queue a text; return the number of texts before it. Any thread may call this.

        A text that is empty or too long, or one too many, is a `LipsyncError`.
        """
        if not text.strip():
            raise LipsyncError("the text is empty; write at least one word")
        if len(text) > MAX_SPOKEN_CHARS:
            raise LipsyncError(
                f"the text has {len(text)} characters, more than {MAX_SPOKEN_CHARS}; "
                "send it in parts"
            )
        with self.lock:
            if self.pending >= MAX_WAITING_TEXTS:
                raise LipsyncError(f"{MAX_WAITING_TEXTS} texts wait already; send this text later")
            self.pending += 1
            before = self.pending - 1
        self.texts.put(text)
        return before

    def _work(self) -> None:
        while True:
            text = self.texts.get()
            try:
                for sentence in SENTENCE_END.split(text):
                    try:
                        if sentence.strip():
                            self.perform(self.speak(sentence))
                    except LipsyncError as error:
                        self.complain(str(error))
            finally:
                with self.lock:
                    self.pending -= 1
