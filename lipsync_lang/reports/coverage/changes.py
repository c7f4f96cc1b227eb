"""Changes since an older coverage document: bigrams, work, and the lines of the script."""

from collections import Counter
from collections.abc import Iterator, Sequence
from hashlib import blake2b
from pathlib import Path

from pydantic import ValidationError

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reading import MIB_BYTES, read_input
from lipsync_lang.reports.coverage.report import (
    COVERAGE_FORMAT,
    Coverage,
    CoverageChanges,
    ReportChange,
    ScriptChange,
    ScriptLines,
)
from lipsync_lang.reports.coverage.total import total_of
from lipsync_lang.text.lines import Line

MAX_DOCUMENT_BYTES = 256 * MIB_BYTES
"""Maximum size of a document; the largest corpora give a few MiB."""

MAX_COMPARED_LINES = 100_000
"""Maximum number of lines with digests; a larger script is not compared."""

LINE_DIGEST_BYTES = 5


def read_document(path: Path) -> Coverage:
    """Read a document that was written as JSON."""
    content = read_input(path, MAX_DOCUMENT_BYTES, mend="check that it is a coverage document")
    try:
        return Coverage.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(step) for step in first["loc"])
        what = f"is not a '{COVERAGE_FORMAT}' document ({where or 'file'}: {first['msg']})"
        mend = f"write one with coverage ... --format json -o {path.name}"
        raise LipsyncError(f"{path}: {what}; {mend}") from None


def since(old: Coverage, new: Coverage, file: str) -> Coverage:
    """Return the new document with its changes since an older one."""
    before, now = (
        {(report.label, report.character): report for report in document.reports}
        for document in (old, new)
    )
    reports: list[ReportChange] = []
    for pair in (pair for pair in now if pair in before):
        one, other = before[pair], now[pair]
        was, has = ({b.bigram for b in r.bigrams if b.authored} for r in (one, other))
        needed, needs = ([b.bigram for b in r.bigrams] for r in (one, other))
        reports.append(
            ReportChange(
                language=other.language,
                character=other.character,
                percent=(one.authored.percent, other.authored.percent),
                left=(one.left.bigrams, other.left.bigrams),
                authored=tuple(name for name in needs if name in has - was),
                lost=tuple(name for name in needed if name in was - has and name in needs),
                new=tuple(name for name in needs if name not in needed),
                gone=tuple(name for name in needed if name not in needs),
                column=other.column,
            )
        )
    changes = CoverageChanges(
        file=file,
        reports=tuple(reports),
        unmatched=tuple(
            f"{report.label} on {report.character}"
            for pair, report in (before | now).items()
            if (pair in before) != (pair in now)
        ),
        script=tuple(script_changes(old.corpus.script, new.corpus.script)),
        # both with the minutes per bigram of the newer one
        left=(total_of(old.reports, new.minutes).left, total_of(new.reports, new.minutes).left),
    )
    return new.model_copy(update={"since": changes})


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
        unnamed = {place: digest for name, place, digest in self._found if name not in named}
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
    # Lines are added at the end more often than before the others.
    for place, digest in reversed(lines.unnamed.items()):
        if wanted[digest] > 0:
            wanted[digest] -= 1
            yield place
