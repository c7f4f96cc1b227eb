"""Faults of pack files: each has a place, a code, a message and a hint to mend it."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple

from lipsync_lang.base.errors import PackError
from lipsync_lang.packs.yaml.events import load_yaml

Severity = Literal["fault", "warning"]


class FaultCode(NamedTuple):
    """A kind of fault in packs, as the reference describes it."""

    meaning: str
    """The mistake, as a sentence."""

    cause: str
    """The usual reasons for the mistake."""

    cure: str
    """The way to mend it; may link to pages beside the reference of faults."""


@cache
def fault_codes() -> dict[str, FaultCode]:
    """Return the description of each code, from `fault_codes.yaml`."""
    table = load_yaml(Path(__file__).with_name("fault_codes.yaml").read_text("utf-8"))
    return {code: FaultCode(**words) for code, words in table.items()}


@dataclass(frozen=True, order=True)
class Fault:
    """A mistake at a place of a file; `str` gives the message for the user.

    Parameters
    ----------
    file : path as shown to the user
    line, column : from 1
    code : one of `fault_codes`
    what : the mistake, in the file's own words
    hint : how to mend it; may be empty
    severity : a pack with warnings only can still be used
    """

    file: str
    line: int
    column: int
    code: str
    what: str
    hint: str = ""
    severity: Severity = "fault"

    def __post_init__(self) -> None:
        """Refuse a code that the reference does not list."""
        if self.code not in fault_codes():
            raise ValueError(f"unknown fault code {self.code!r}; add it to fault_codes.yaml first")

    def __str__(self) -> str:
        hint = f"\n  hint: {visible(self.hint)}" if self.hint else ""
        mark = "warning: " if self.severity == "warning" else ""
        place = f"{visible(self.file)}:{self.line}:{self.column}"
        return f"{place}: {self.code} {mark}{visible(self.what)}{hint}"

    def to_dict(self) -> dict[str, str | int]:
        """Return the fault as a dict for JSON."""
        return asdict(self)


def visible(text: str) -> str:
    """Escape unprintable characters, so that a message stays on one line and is harmless."""
    if text.isprintable():
        return text
    # a name of a file may hold the escape sequences of a terminal
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


class PackFaults(PackError):  # noqa: N818 it carries faults, and is raised as them
    """Packs are too faulty to be used; `str` lists every fault."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(map(str, self.faults)))

    def __str__(self) -> str:
        """List every fault, however many there are."""
        return "\n".join(map(str, self.faults))
