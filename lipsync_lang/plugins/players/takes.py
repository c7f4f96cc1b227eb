"""Player of archives of takes (`.takes`): one file, for programs of your own; the standard library.

The players in C, JavaScript and GDScript beside it do the same, step by step. Times are seconds on
the timeline of a line, whose sound starts at `Player.delay`. Lists keep their length: playing makes
no new ones.

Examples
--------
>>> archive = Archive(Path("takes/crab.takes"))  # doctest: +SKIP
>>> player = Player(archive)  # doctest: +SKIP
>>> player.play("english/intro_001")  # doctest: +SKIP
>>> player.advance(1 / 60)  # doctest: +SKIP
>>> dict(zip(archive.poses, player.weights))  # doctest: +SKIP
"""

import struct
from collections.abc import Sequence
from mmap import ACCESS_READ, mmap
from pathlib import Path
from types import TracebackType
from typing import Self
from zlib import crc32

TAKES_MAGIC = b"LLTAKES\0"
TAKES_VERSION = 1
TAKES_HEADER = struct.Struct("<8sHHIIIQQQIIII")
INDEX_SLOT = struct.Struct("<QII")
TAKE_HEAD = struct.Struct("<fffIHH")
TAKE_TRACK = struct.Struct("<HHIff")
TEXT_LENGTH = struct.Struct("<H")
TAKE_STEPS = 1023
HEAD_CRC_AT = 48
MOST_SECONDS = 1e6
MOST_WEIGHT = 1e9


class TakesError(ValueError):
    """An archive is damaged, of another version, or not an archive."""


class Archive:
    """An archive, mapped into memory.

    Raises TakesError if it is not an archive, is damaged, or has another version.
    """

    def __init__(self, path: Path) -> None:
        with path.open("rb") as stream:
            if not stream.read(1):
                raise TakesError(f"{path}: is empty")
            self.data = mmap(stream.fileno(), 0, access=ACCESS_READ)
        try:
            self._read_head()
        except (TakesError, struct.error) as error:
            self.data.close()
            raise TakesError(f"{path}: {error}; make the archive again") from None

    def _read_head(self) -> None:
        data = self.data
        if data[:8] != TAKES_MAGIC:
            raise TakesError("is not an archive of takes")
        _, version, kind, _, slots, poses, index, takes, end, head, *_ = TAKES_HEADER.unpack_from(
            data
        )
        if version != TAKES_VERSION:
            raise TakesError(f"has version {version}; this player reads {TAKES_VERSION}")
        if kind:
            raise TakesError("is a patch, not an archive")
        if end != len(data):
            raise TakesError(f"has {len(data)} bytes of {end}")
        whole = (
            TAKES_HEADER.size <= index <= takes <= end and takes - index == slots * INDEX_SLOT.size
        )
        # The slots are a power of two, so that a mask finds the slot of a hash.
        if not whole or not slots or slots & (slots - 1):
            raise TakesError("its parts overlap")
        # The checksum leaves out its own four bytes.
        if crc32(data[HEAD_CRC_AT + 4 : takes], crc32(data[:HEAD_CRC_AT])) != head:
            raise TakesError("the checksum of its index is wrong")
        self.slots, self.index = slots, index
        names, at = [], TAKES_HEADER.size
        for _ in range(poses):
            length = TEXT_LENGTH.unpack_from(data, at)[0]
            names.append(data[at + 2 : at + 2 + length].decode(errors="replace"))
            at += 2 + length
            if at > index:
                raise TakesError("its names of poses are damaged")
        self.poses = tuple(names)
        """Names of the poses, in the order of `Player.weights`."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:  # fmt: skip
        self.data.close()

    def is_whole(self) -> bool:
        """Return True if the checksum of all takes is right; it reads the whole file."""
        body, takes = (
            TAKES_HEADER.unpack_from(self.data)[10],
            TAKES_HEADER.unpack_from(self.data)[7],
        )
        with memoryview(self.data) as view, view[takes:] as part:
            return bool(crc32(part) == body)

    def find(self, name: str) -> tuple[int, int]:
        """Return the bytes of a take such as `english/intro_001`: first and end; 0, 0: none."""
        text, value = name.encode(), 0x811C9DC5
        # FNV-1a, as the archive was written; a name whose slot is taken is in the next free one.
        for byte in text:
            value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
        for probe in range(self.slots):
            slot = (value + probe) & (self.slots - 1)
            at, found, size = INDEX_SLOT.unpack_from(self.data, self.index + slot * INDEX_SLOT.size)
            if not at:
                break
            if found == value and at + size <= len(self.data) and size >= 4 + len(text):
                length = TEXT_LENGTH.unpack_from(self.data, at)[0]
                if length == len(text) and self.data[at + 4 : at + 4 + length] == text:
                    body = at + 4 + length + -length % 4
                    return (body, at + size) if self._is_sound(body, at + size) else (0, 0)
        return 0, 0

    def _is_sound(self, body: int, end: int) -> bool:
        """Return True if the head of a take and its tracks are sound; keys are checked in play."""
        if body + TAKE_HEAD.size > end:
            return False
        rate, start, delay, frames, tracks, _ = TAKE_HEAD.unpack_from(self.data, body)
        first = body + TAKE_HEAD.size
        timed = 0 < rate < MOST_SECONDS and abs(start) < MOST_SECONDS and abs(delay) < MOST_SECONDS
        last = first + tracks * TAKE_TRACK.size
        if not timed or not frames or tracks > len(self.poses) or last > end:
            return False
        for track in range(first, last, TAKE_TRACK.size):
            pose, count, keys, low, span = TAKE_TRACK.unpack_from(self.data, track)
            if pose >= len(self.poses) or not count or body + keys + 2 > end:
                return False
            if not (abs(low) < MOST_WEIGHT and abs(span) < MOST_WEIGHT):
                return False
        return True


class _Cursor:
    """The span between two keys of a track."""

    def __init__(self) -> None:
        self.pose = self.at = self.left = self.first = self.last = 0
        self.place = self.count = 0
        self.low = self.scale = self.begin = self.end = 0.0


class Player:
    """Player of lines of an archive.

    `weights` has the weight of each pose of the archive now, and 0 at rest.
    """

    def __init__(self, archive: Archive) -> None:
        self.archive = archive
        self.weights = [0.0] * len(archive.poses)
        self.time = self.start = self.delay = self.end = self.rate = 0.0
        self.frames = 0
        self.playing = False
        self._from = [0.0] * len(archive.poses)
        self._fade = self._left = 0.0
        self._cursors = [_Cursor() for _ in archive.poses]
        self._tracks = self._stop = 0

    @property
    def sound_time(self) -> float:
        """Seconds of the sound now; it has not started below 0."""
        return self.time - self.delay

    def play(self, name: str, fade: float = 0.0, at: float | None = None) -> bool:
        """Play a line. It begins with its movement before the sound, or at a time, and fades in.

        Returns False, and goes on as before, if the archive lacks the line.
        """
        body, stop = self.archive.find(name)
        if not body:
            return False
        data = self.archive.data
        rate, start, delay, frames, tracks, _ = TAKE_HEAD.unpack_from(data, body)
        self._hold(fade)
        self._stop = stop
        self.rate, self.start, self.delay, self.frames = rate, start, delay, frames
        self._tracks, self.end, self.playing = tracks, start + (frames - 1) / rate, True
        for number in range(tracks):
            one = self._cursors[number]
            place = body + TAKE_HEAD.size + number * TAKE_TRACK.size
            one.pose, one.count, keys, one.low, span = TAKE_TRACK.unpack_from(data, place)
            one.place, one.scale = body + keys, span / TAKE_STEPS
            self._rewind(one)
        self.time = min(0.0, start) if at is None else at
        self._show()
        return True

    def switch(self, name: str, fade: float = 0.0) -> bool:
        """Play the same line in another language, from the same share of its length."""
        share = (self.time - self.start) / max(self.end - self.start, 1e-6)
        if not self.play(name, fade):
            return False
        self.time = self.start + share * (self.end - self.start)
        self._show()
        return True

    def advance(self, seconds: float) -> None:
        """Move on by the time of a frame."""
        self.time += seconds
        self._left = max(0.0, self._left - seconds)
        self._show()

    def seek(self, time: float) -> None:
        """Go to a time on the line's timeline; a fade ends."""
        self.time, self._left = time, 0.0
        self._show()

    def skip(self, fade: float = 0.0) -> None:
        """End the line: fade to rest."""
        self._hold(fade)
        self.playing, self._tracks = False, 0
        self._show()

    def blend(
        self, own: Sequence[float], mode: str, region: Sequence[float], out: list[float]
    ) -> None:
        """Combine speech with the game's own weights into `out`.

        `max` takes the larger and `add` the sum, up to 1; `replace` takes speech where `region`
        is 1 and the game's own where it is 0.
        """
        for pose, speech in enumerate(self.weights):
            if mode == "max":
                out[pose] = max(own[pose], speech)
            elif mode == "add":
                out[pose] = min(own[pose] + speech, 1.0)
            else:
                out[pose] = own[pose] + (speech - own[pose]) * region[pose]

    def _hold(self, fade: float) -> None:
        self._from[:] = self.weights
        self._fade = self._left = max(0.0, fade)

    def _rewind(self, one: _Cursor) -> None:
        word = TEXT_LENGTH.unpack_from(self.archive.data, one.place)[0]
        one.at, one.left = one.place + 2, one.count - 1
        one.first = one.last = 0
        one.begin = one.end = one.low + (word & TAKE_STEPS) * one.scale

    def _next(self, one: _Cursor) -> None:
        """Go to the next key; a damaged curve holds where its keys run out."""
        data, at = self.archive.data, one.at
        word = TEXT_LENGTH.unpack_from(data, at)[0] if at + 2 <= self._stop else 0
        step = word >> 10
        # 6 bits hold no longer step than 63: a step of 0 is in the next word.
        if not step:
            at += 2
            if at + 2 > self._stop:
                one.left = 0
                return
            step = TEXT_LENGTH.unpack_from(data, at)[0]
        one.at = at + 2
        one.left -= 1
        one.first, one.begin = one.last, one.end
        one.last += step
        one.end = one.low + (word & TAKE_STEPS) * one.scale

    def _show(self) -> None:
        weights = self.weights
        for pose in range(len(weights)):
            weights[pose] = 0.0
        frame = min(max((self.time - self.start) * self.rate, 0.0), max(self.frames - 1.0, 0.0))
        for number in range(self._tracks):
            one = self._cursors[number]
            # Keys lead forwards only, so a way back starts at the first.
            if frame < one.first:
                self._rewind(one)
            while frame > one.last and one.left:
                self._next(one)
            share = (frame - one.first) / (one.last - one.first) if one.last > one.first else 1.0
            weights[one.pose] = one.begin + (one.end - one.begin) * share
        if self.time >= self.end:
            self.playing = False
        if self._left > 0:
            share = self._left / self._fade
            for pose in range(len(weights)):
                weights[pose] += (self._from[pose] - weights[pose]) * share
