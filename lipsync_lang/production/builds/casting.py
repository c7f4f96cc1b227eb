"""Packs of a project: its languages, and the characters of its speakers."""

from pathlib import Path

from lipsync_lang.packs.finding import POSESET, Finder
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.speaker_faces import OTHERS, SpeakerFaces, stated_faces, unique
from lipsync_lang.production.builds.script_faults import ScriptFaults
from lipsync_lang.production.builds.script_files import ScriptLanguage


def languages_of(
    project: Project, finder: Finder, faults: ScriptFaults
) -> dict[int, ScriptLanguage]:
    """Return the languages of a build by their index."""
    stated = project.languages or ({project.language: None} if project.language else {})
    if not stated:
        faults.state((), "P401", "no `languages`", "state `languages: [NAME, ...]`")
    found: dict[int, ScriptLanguage] = {}
    for own, word in stated.items():
        path = next(map(Path, finder.lookup("language", own)), None)  # ENGINE:CODE has no pack
        name = own if path is None else path.stem
        names = finder.column_names(own, word)
        found[len(found)] = ScriptLanguage(name, word or own.replace(":", "-"), names)
    return found


class Cast:
    """The characters of each speaker."""

    def __init__(self, project: Project, finder: Finder, faults: ScriptFaults) -> None:
        stated = stated_faces(project)
        if not stated:
            hint = "state `character: NAME` or `cast: {...}`"
            faults.state((), "P401", "no `character`", hint)
        faces: dict[str, tuple[str, ...]] = {}
        for speaker, names in stated.items():
            own: list[str] = []
            for name in names:
                found = finder.lookup("character", name) or finder.lookup("poseset", name)
                paths = map(Path, found[:1])  # an unknown one is a fault of `check_characters`
                own += (one.parent.name if one.name == POSESET else one.stem for one in paths)
            faces[speaker] = unique(own)
        self._faces = SpeakerFaces(faces)
        self.characters = self._faces.characters
        """Every character once."""
        self.faults = faults
        self._unknown: dict[str, str] = {}
        """Speakers without characters, with the places of their first lines."""
        self.met: set[str] = set()
        """Speakers of `cast` that a line has, folded."""

    @property
    def most(self) -> int:
        """Maximum number of characters per line."""
        return max(map(len, self._faces.stated.values()), default=0)

    def of(self, speaker: str, where: str) -> tuple[str, ...]:
        """Return the characters of a speaker; `check_speakers` reports those without one."""
        if self._faces.own(speaker):
            self.met.add(speaker.casefold())
        found = self._faces.of(speaker)
        if not found and self._faces.stated:
            self._unknown.setdefault(speaker, where)
        return found

    def check_speakers(self) -> None:
        """Add one fault for all speakers without a character, at the first of their lines."""
        if self._unknown:
            where = next(iter(self._unknown.values()))
            self.faults.add(where, self._faces.lacking(*self._unknown))

    def unmet(self) -> list[str]:
        """Return the speakers of `cast` that no line has."""
        return sorted(
            speaker
            for speaker in self._faces.stated
            if speaker != OTHERS and speaker.casefold() not in self.met
        )
