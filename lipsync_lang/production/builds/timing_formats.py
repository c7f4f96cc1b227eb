"""Formats of timings and scripts that a project states: known until another is opened."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.project import FILE
from lipsync_lang.packs.yaml.faults import Fault, PackFaults
from lipsync_lang.production.builds.known_projects import known_project
from lipsync_lang.production.builds.script_faults import in_words_of_project

if TYPE_CHECKING:  # workers start faster without the models of packs
    from lipsync_lang.base.extensions import Formats
    from lipsync_lang.packs.models import Project
    from lipsync_lang.packs.models.fields import Strict
    from lipsync_lang.packs.pack import Pack

TimingFormats = Mapping[str, Mapping[str, Any]]
"""Plain fields of formats, by name."""

_script_names: list[str] = []
"""Formats of scripts of the project that is open."""


def open_project(path: Path) -> "Pack[Project]":
    """Load a project, and let files be read in its formats of timings and scripts.

    Raises an error if it is unsound, or a link out of its folder.
    """
    use_timing_formats({})
    use_script_formats({})
    pack = known_project(path)
    if faults := [*check_timing_formats(pack)]:
        raise PackFaults(faults)
    use_timing_formats(plain_formats(pack.model.timing_formats))
    use_script_formats(plain_formats(pack.model.script_formats))
    return pack


def plain_formats(stated: "Mapping[str, Strict]") -> TimingFormats:
    """Return the formats of a project as plain data, which workers receive."""
    return {name: one.model_dump(exclude_none=True) for name, one in stated.items()}


def use_timing_formats(formats: TimingFormats) -> None:
    """Let files be read in these formats, and no longer in those of an earlier project."""
    from lipsync_lang.schedules.records import record_format
    from lipsync_lang.schedules.timing_readers import TIMING_READERS

    TIMING_READERS.drop(FILE)
    for name, fields in formats.items():
        TIMING_READERS.add(name, record_format(name, fields).reader(), FILE)


def use_script_formats(formats: TimingFormats) -> None:
    """Let scripts be read in these formats, and no longer in those of an earlier project."""
    if not formats and not _script_names:
        return
    from lipsync_lang.text.lines.json_scripts import JSON_SCRIPTS
    from lipsync_lang.text.lines.line_readers import LINE_READERS, by_suffix
    from lipsync_lang.text.lines.script_formats import add_script
    from lipsync_lang.text.lines.xml_scripts import XML_SCRIPTS

    for name in _script_names:
        JSON_SCRIPTS.pop(name, None)
        XML_SCRIPTS.pop(name, None)
    LINE_READERS.drop(FILE)
    _script_names[:] = formats
    for name, fields in formats.items():
        facts = {"title": f"Scripts of {name}.", **fields, "suffixes": (fields["suffix"],)}
        del facts["suffix"]
        add_script(name, facts if "entries" in facts else {**facts, "anywhere": True}, FILE)
    by_suffix.cache_clear()


def check_timing_formats(pack: "Pack[Project]") -> Iterator[Fault]:
    """Yield a fault for each format with the name of one that the program or a plug-in has."""
    if not pack.model.timing_formats and not pack.model.script_formats:
        return
    from lipsync_lang.schedules.timing_readers import TIMING_READERS
    from lipsync_lang.text.lines.line_readers import LINE_READERS

    kinds: tuple[tuple[str, Formats[Any]], ...] = (
        ("timing_formats", TIMING_READERS),
        ("script_formats", LINE_READERS),
    )
    for kind, known in kinds:
        for name in sorted(getattr(pack.model, kind).keys() & known.beside(FILE)):
            what = f"there is a format '{name}' already"
            yield pack.fault((kind, name), "P106", what, "choose another name", key=True)


def formats_for(project: "Project", path: Path) -> list[tuple[str, str]]:
    """Return (field, name) of the formats of a project with the suffix of a file."""
    file, scripts = path.name.lower(), project.script_formats.items()
    found = [("script_formats", name) for name, one in scripts if file.endswith(one.suffix)]
    if file.endswith((".json", ".jsonl")):
        found += [("timing_formats", name) for name in project.timing_formats]
    return found


def check_files(pack: "Pack[Project]", files: Iterable[Path]) -> Iterator[Fault]:
    """Yield the faults of files that have a suffix of the open project's formats, and no fit."""
    for path in files:
        told: list[Fault] = []
        for kind, name in formats_for(pack.model, path):
            try:
                _try(kind, name, path, pack.model.encoding)
                break
            except LipsyncError as error:
                what = f"does not fit {in_words_of_project(error)}"
                told.append(pack.fault((kind, name), "P409", what, key=True))
        else:
            yield from told


def _try(kind: str, name: str, path: Path, encoding: str | None) -> None:
    """Read a file in a format of the project; timings may be in any other, too."""
    from lipsync_lang.schedules.timing_file import TimingFile, unnamed_encoding
    from lipsync_lang.schedules.timing_readers import read_timings
    from lipsync_lang.text.lines import read_lines
    from lipsync_lang.text.lines.json_scripts import JSON_SCRIPTS

    if kind == "script_formats":
        _ = [*read_lines(path, encoding=encoding, remark=lambda _: None)]
        own, file = JSON_SCRIPTS.get(name), TimingFile.of(path, encoding=encoding)
        if own is not None and not own.fits(file.document):  # another format has read it
            raise own.misfit(file)
        return
    with unnamed_encoding():
        try:
            read_timings(path)
        except LipsyncError:
            read_timings(path, read_as=name)
            raise
