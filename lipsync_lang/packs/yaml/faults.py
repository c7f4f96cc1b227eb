"""Faults of pack files: each has a place, a code, a message and a hint to mend it."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from lipsync_lang.errors import PackError

Severity = Literal["fault", "warning"]

CODES: dict[str, str] = {
    # P0: the file as YAML
    "P001": "The file cannot be opened.",
    "P002": "The file is larger than any pack.",
    "P003": "The file is not UTF-8 text.",
    "P004": "The file starts with a byte order mark.",
    "P005": "The file has a character that is not allowed in text.",
    "P006": "The file is empty.",
    "P007": "A tab is used for indentation, where YAML needs spaces.",
    "P008": "The file is not valid YAML.",
    "P009": "The file holds more than one document.",
    "P010": "The file nests deeper than any pack.",
    "P011": "The file is larger than any pack, once its aliases are written out.",
    "P012": "An alias has no anchor, or lies within an anchored value.",
    "P013": "A merge key (`<<`) is used.",
    "P014": "A tag (`!`) is used.",
    "P015": "A key is stated twice.",
    "P016": "A key is not plain text.",
    "P017": "The file asks for another version of YAML.",
    # P1: the form of one pack
    "P101": "A field is unknown.",
    "P102": "A field is missing.",
    "P103": "A value is of the wrong type.",
    "P104": "A number is out of range.",
    "P105": "A number is not finite.",
    "P106": "A name or label is malformed.",
    "P107": "A word is not one of the known words.",
    "P108": "A list has too few or too many items.",
    "P109": "The kind of pack is unknown, or does not belong here.",
    "P110": "The pack is in a newer format than this program reads.",
    "P111": "The name of the pack differs from that of its file or folder.",
    "P112": "A bigram key has three or more parts, which are reserved for longer units.",
    "P113": "The times of a curve fall.",
    "P114": "The shares of a phoneme's time do not fit its parts.",
    "P115": "Fields of one entry contradict each other.",
    "P116": "Text is empty.",
    "P117": "A context of a rule is not a regular expression.",
    "P118": "A context of a rule could take too long to match.",
    # P2: what one part says of another
    "P201": "A pose is unknown to the pose set.",
    "P202": "A common phoneme is unknown.",
    "P203": "A pose set is unknown.",
    "P204": "A bank or rig belongs to another pose set.",
    "P205": "An entry appears twice in a list.",
    "P206": "Constraints form a circle.",
    "P207": "A contact pose has to yield to another pose.",
    "P208": "A constraint keeps two contact poses below their floors.",
    "P209": "A pose has a ceiling below the floor that a contact gives it.",
    "P210": "A language is unknown.",
    "P211": "Languages extend each other in a circle.",
    "P212": "A rig is unknown.",
    "P213": "A file that a pack names is missing.",
    "P214": "A channel is unknown to the rig.",
    "P215": "A phoneme of the common pack is declared again.",
    "P216": "A pair of poses is constrained twice, or a pose with itself.",
    "P217": "A notation is unknown to the language.",
    "P218": "A label is not in the expected notation.",
    "P219": "Two labels of a notation have the same spelling, but different mappings.",
    "P220": "A phoneme of the inventory is neither mapped nor listed as absent.",
    "P221": "A test of a language fails.",
    "P222": "A feature, or a word that describes letters, is unknown to the IPA pack.",
    "P223": "A letter or mark is unknown to the IPA pack.",
    "P224": "Two poses have the same shape name of a model.",
    "P225": "The face at rest has the name of a pose.",
    "P226": "A voice is unknown to its speech engine.",
    "P227": "The parent of a shade is a shade.",
    "P230": "A region is unknown to the pose set.",
    "P231": "A measure is unknown to the pose set.",
    # W3: sound, but probably not meant
    "W301": "A pose has no target, so drafts never move it.",
    "W302": "A constraint links two poses of equal priority, so neither yields.",
    "W303": "A file in a folder of packs is not read.",
    "W304": "An installed distribution offers packs that cannot be found.",
    "W305": "Two languages have the same tag or alias, so it always finds the first one.",
    "W306": "The curve of a bigram misses the contact of its phoneme.",
    "W307": "A rule never fires, because an earlier one takes its letters.",
    "W308": "An entry cannot be reached, or has no effect.",
    "W309": "A mapping contradicts the features of its sound.",
    "W310": "The tests of a language could not be run.",
    "W311": "A pose drives no channel of a rig, and the rig does not list it as lost.",
    "W312": "A contact has no effect.",
    "W313": "A threshold is never reached, so it has no effect.",
    "W314": "A target disagrees with a contact of its phoneme.",
    "W320": "No bank has the requested style.",
}
"""The meaning of each code. A meaning never changes, and a retired code is never used again."""


@dataclass(frozen=True, order=True)
class Fault:
    """A mistake at a place of a file; `str` gives the message for the user.

    Parameters
    ----------
    file : path as shown to the user
    line, column : from 1
    code : one of `CODES`
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
        if self.code not in CODES:
            raise ValueError(f"unknown fault code {self.code!r}; add it to CODES first")

    def __str__(self) -> str:
        hint = f"\n  hint: {_visible(self.hint)}" if self.hint else ""
        mark = "warning: " if self.severity == "warning" else ""
        place = f"{_visible(self.file)}:{self.line}:{self.column}"
        return f"{place}: {self.code} {mark}{_visible(self.what)}{hint}"

    def to_dict(self) -> dict[str, str | int]:
        """Return the fault as a dict for JSON."""
        return asdict(self)


def _visible(text: str) -> str:
    """Escape unprintable characters, so that a message stays on one line and is harmless."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


class PackFaults(PackError):  # noqa: N818 it carries faults, and is raised as them
    """Packs are too faulty to be used; `str` lists every fault."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(map(str, self.faults)))

    def __str__(self) -> str:
        """List every fault, however many there are."""
        return "\n".join(map(str, self.faults))


def shown(path: Path) -> str:
    """Return a path for a message: relative to the current folder if it lies below."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return str(path)
