"""Shards: disjoint parts of a project that machines build with nothing shared but its folder.

A line belongs to a shard by its id and language, so it stays there when others come and go, and
all characters share its timings. Archives and the record of a shard have names of their own.
"""

from dataclasses import dataclass
from pathlib import PurePath
from typing import Self
from zlib import crc32

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.production.builds.archives import split_archive


@dataclass(frozen=True)
class Shard:
    """A part of a project."""

    number: int
    """From 1."""
    parts: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Parse ``3/16``; raises LipsyncError.

        >>> Shard.parse("3/16")
        Shard(number=3, parts=16)
        """
        number, _, count = text.partition("/")
        if number.isascii() and number.isdecimal() and count.isascii() and count.isdecimal():
            found = cls(int(number), int(count))
            if 1 <= found.number <= found.parts:
                return found
        raise LipsyncError(f"--shard {text}: give a part and the number of parts, such as 3/16")

    @property
    def name(self) -> str:
        """Its name in paths."""
        return f"{self.number}-of-{self.parts}"

    def has(self, language: str, line: str) -> bool:
        """Return True if a line belongs to the shard."""
        return crc32(f"{language}/{line}".encode()) % self.parts == self.number - 1

    def named(self, path: str) -> str:
        """Return a path with the shard in the name of its file.

        >>> Shard(3, 16).named("takes/crab.takes")
        'takes/crab.3-of-16.takes'
        """
        pure = PurePath(path)
        return pure.with_name(f"{pure.stem}.{self.name}{pure.suffix}").as_posix()

    def output(self, path: str) -> str:
        """Return an output of the shard; only archives have other names than in a whole build."""
        split = split_archive(path)
        return path if split is None else f"{self.named(split[0])}/{split[1]}"
