"""The characters of each speaker, as a project's `cast` names them."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import MAX_KNOWN, shortlist

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project

OTHERS = "*"
"""The speaker that stands for all others."""


class SpeakerFaces:
    """The characters of each speaker.

    Parameters
    ----------
    stated : characters by speaker; `*` stands for all other speakers
    """

    def __init__(self, stated: Mapping[str, Sequence[str]]) -> None:
        self.stated = {speaker: tuple(found) for speaker, found in stated.items()}
        # scripts write one name as `Anna` and `ANNA`
        self._folded = {speaker.casefold(): found for speaker, found in self.stated.items()}

    @property
    def characters(self) -> tuple[str, ...]:
        """Every character once."""
        return unique(name for names in self.stated.values() for name in names)

    def own(self, speaker: str) -> tuple[str, ...]:
        """Return the characters that are stated for a speaker; empty if there are none."""
        return self.stated.get(speaker) or self._folded.get(speaker.casefold(), ())

    def of(self, speaker: str) -> tuple[str, ...]:
        """Return the characters of a speaker, or those of all others."""
        return self.own(speaker) or self.stated.get(OTHERS, ())

    @staticmethod
    def lacking(*speakers: str) -> str:
        """Return the message for speakers without characters."""
        each = (f"'{speaker}'" if speaker else "no speaker" for speaker in speakers)
        them = "them" if len(speakers) > 1 else "the speaker"
        who = shortlist(each, MAX_KNOWN)
        return f"no character for {who}; add {them} or '{OTHERS}' to `cast`"


def stated_faces(project: "Project") -> dict[str, tuple[str, ...]]:
    """Return the `cast` of a project, whose `character` speaks for all others by default."""
    stated = dict(project.cast)
    if project.character and OTHERS not in stated:
        stated[OTHERS] = (project.character,)
    return stated


def unique(names: Iterable[str]) -> tuple[str, ...]:
    """Return each name once, in order."""
    return tuple(dict.fromkeys(names))
