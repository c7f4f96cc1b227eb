"""Plain text."""

from collections.abc import Iterator

from lipsync_lang.text.lines.line_readers import Line, LineFile, reader


@reader("text", suffixes=[".txt"])
def read(source: LineFile) -> Iterator[Line]:
    """Plain text: each row is a line; empty rows are skipped."""
    for number, text in source.numbered():
        if text.strip():
            yield source.line(number, text)
