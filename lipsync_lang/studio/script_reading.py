"""The reading of a script as the studio's project states it: its column and its speakers."""

from dataclasses import dataclass

from lipsync_lang.packs.project import find_project, load_project
from lipsync_lang.packs.speaker_faces import SpeakerFaces, stated_faces
from lipsync_lang.reports.coverage.corpus import Takes
from lipsync_lang.studio.workshop import Workshop


@dataclass(frozen=True)
class ScriptReading:
    """The reading of a script for the open pair; two equal readings count the same lines."""

    column: str | None
    """Column of a table, by name or number; None for the one that is named after the language."""
    names: tuple[str, ...] = ()
    """Names of the language, which a column may have."""
    speaker: str | None = None
    """Column of the speakers; None for the likeliest."""
    encoding: str | None = None
    """Encoding of the file; None for UTF-8, or what the file's mark says."""
    cast: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """Speakers with their characters; empty if the open character speaks every line."""
    character: str = ""

    @property
    def faces(self) -> SpeakerFaces | None:
        """The characters of the speakers; None if the open character speaks every line."""
        return SpeakerFaces(dict(self.cast)) if self.cast else None

    @property
    def takes(self) -> Takes | None:
        """The choice of the open character's lines; None for every line."""
        faces = self.faces
        return None if faces is None else lambda line: self.character in faces.of(line.speaker)


def reading_of(workshop: Workshop, column: str | None, *, sent: bool) -> ScriptReading:
    """Return the reading of a script for the open pair.

    A character that the project's `cast` does not name speaks every line: somebody chose it. The
    user states `column`; None is the project's, or the language's own. A script that was `sent`
    has no columns of the project. Raises LipsyncError if the project file is unsound.
    """
    file = find_project(workshop.project)
    project = None if file is None else load_project(file).model
    given, finder = workshop.language, workshop.library()
    paths = () if ":" in given else finder.lookup("language", given)
    own = [
        name
        for name in ({} if project is None else project.languages)
        if name == given or (paths and ":" not in name and finder.lookup("language", name) == paths)
    ]
    word = given if project is None or not own else project.languages[own[0]] or own[0]
    names = finder.column_names(given, word)
    if project is None:
        return ScriptReading(column, names)
    character = workshop.character
    faces = SpeakerFaces(stated_faces(project) if project.cast else {})
    cast = tuple(faces.stated.items()) if character in faces.characters else ()
    if sent:
        return ScriptReading(column, names, cast=cast, character=character)
    stated = project.columns.text and project.columns.text.replace("{language}", word)
    return ScriptReading(
        column or stated, names, project.columns.speaker, project.encoding, cast, character
    )
