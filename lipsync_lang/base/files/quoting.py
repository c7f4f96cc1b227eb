"""Quote parts of a command for the shell of this system, and text for spreadsheets and XML."""

import re
import shlex
import sys
from collections.abc import Iterable

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
"""First characters of formulas in any spreadsheet."""

# what is forbidden, for a pattern of what is allowed takes 10 ms to compile
_FORBIDDEN = "[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]"


def shell_command(parts: Iterable[str]) -> str:
    """Join the parts of a command, quoted for cmd and PowerShell on Windows, else for sh."""
    if sys.platform != "win32":
        return shlex.join(parts)
    from subprocess import list2cmdline

    return list2cmdline(parts)


def spreadsheet_text(text: str) -> str:
    """Put an apostrophe before text that a spreadsheet would evaluate, as OWASP recommends.

    Text that has apostrophes before a formula gets one more, so that `plain_text` is exact.
    """
    return f"'{text}" if text.lstrip("'").startswith(FORMULA_STARTS) else text


def plain_text(cell: str) -> str:
    """Return the text of which `spreadsheet_text` made a cell."""
    quoted = cell.startswith("'") and cell.lstrip("'").startswith(FORMULA_STARTS)
    return cell[1:] if quoted else cell


def xml_text(text: str) -> str:
    """Return text with a replacement character for each character that XML 1.0 forbids."""
    return re.sub(_FORBIDDEN, "\N{REPLACEMENT CHARACTER}", text)
