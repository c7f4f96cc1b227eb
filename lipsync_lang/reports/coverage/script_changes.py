"""Digests of a script's lines, for a comparison with an older document."""

from collections import Counter
from collections.abc import Iterator, Sequence
from hashlib import blake2b

from lipsync_lang.reports.coverage.facts import Fact
from lipsync_lang.text.lines import Line

MAX_COMPARED_LINES = 100_000
"""Maximum number of lines with digests; a larger script is not compared."""

LINE_DIGEST_BYTES = 5


class ScriptLines(Fact):
    """Digests of the spoken lines of one reading, in its order."""

    languages: tuple[str, ...]
    """Languages that the lines were read in."""
    column: str = ""
    """The column that was read; empty unless it was stated."""
    named: dict[str, str]
    """Digests by the line's own name."""
    unnamed: dict[str, str]
    """Digests by place, for lines without a name of their own."""


class ScriptChange(Fact):
    """Changes of a script's lines since an older document."""

    languages: tuple[str, ...]
    """Languages in which the same lines changed."""
    lines: tuple[int, int]
    """Number of lines, before and now."""
    added: tuple[str, ...]
    """Names, or places, of new lines."""
    removed: tuple[str, ...]
    """Names, or former places, of removed lines."""
    changed: tuple[str, ...]
    """Names of lines with another text or speaker."""


class ScriptDigests:
    """Collector of digests during the reading of lines."""

    def __init__(self) -> None:
        self._found: list[tuple[str, str, str]] = []
        self._lines = 0

    def add(self, line: Line) -> None:
        """Add a line."""
        self._lines += 1
        if self._lines > MAX_COMPARED_LINES:
            self._found.clear()
        else:
            said = line.text if line.schedule is None else " ".join(line.schedule.labels)
            whole = f"{line.speaker}\n{said}".encode("utf-8", "surrogatepass")
            digest = blake2b(whole, digest_size=LINE_DIGEST_BYTES).hexdigest()
            self._found.append((line.name, line.place, digest))

    def lines(self, languages: Sequence[str]) -> tuple[ScriptLines, ...]:
        """Return the digests of all lines; none for a script that is too large.

        A name that several lines share is ignored.
        """
        if not self._found:
            return ()
        times = Counter(name for name, _, _ in self._found)
        named = {name: digest for name, _, digest in self._found if name and times[name] == 1}
        unnamed = {
            place: digest for name, place, digest in self._found if not name or times[name] > 1
        }
        return (ScriptLines(languages=tuple(languages), named=named, unnamed=unnamed),)


def script_changes(
    old: Sequence[ScriptLines], new: Sequence[ScriptLines]
) -> Iterator[ScriptChange]:
    """Yield the changes of the readings in both documents; equal changes are merged."""
    before = {(one.languages, one.column): one for one in old}
    groups: dict[ScriptChange, list[str]] = {}
    for now in new:
        was = before.get((now.languages, now.column))
        if was is None:
            continue
        come = Counter(now.unnamed.values()) - Counter(was.unnamed.values())
        gone = Counter(was.unnamed.values()) - Counter(now.unnamed.values())
        change = ScriptChange(
            languages=(),
            lines=(len(was.named) + len(was.unnamed), len(now.named) + len(now.unnamed)),
            added=(*(name for name in now.named if name not in was.named), *_places(now, come)),
            removed=(*(name for name in was.named if name not in now.named), *_places(was, gone)),
            changed=tuple(
                name for name, digest in now.named.items() if was.named.get(name, digest) != digest
            ),
        )
        groups.setdefault(change, []).extend(now.languages)
    for change, languages in groups.items():
        yield change.model_copy(update={"languages": tuple(dict.fromkeys(languages))})


def _places(lines: ScriptLines, wanted: Counter[str]) -> Iterator[str]:
    """Yield the places of lines with given digests, the last of equal lines first."""
    for place, digest in reversed(lines.unnamed.items()):
        if wanted[digest] > 0:
            wanted[digest] -= 1
            yield place
