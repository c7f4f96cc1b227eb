"""Changes since an older coverage document."""

from pathlib import Path

from pydantic import ValidationError

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reading import MIB_BYTES, read_input
from lipsync_lang.reports.coverage.report import (
    COVERAGE_FORMAT,
    Coverage,
    CoverageChanges,
    ReportChange,
)
from lipsync_lang.reports.coverage.script_changes import script_changes
from lipsync_lang.reports.coverage.total import total_of

MAX_DOCUMENT_BYTES = 256 * MIB_BYTES
"""Maximum size of a document; the largest corpora give a few MiB."""


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
