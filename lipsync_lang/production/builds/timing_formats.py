"""Formats of timings that a project states: known until another project is opened."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from lipsync_lang.packs.models import Project
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.project import FILE, load_project
from lipsync_lang.packs.yaml.faults import Fault, PackFaults

TimingFormats = Mapping[str, Mapping[str, Any]]
"""Plain fields of formats, by name."""


def open_project(path: Path) -> Pack[Project]:
    """Load a project, and let files be read in its formats of timings.

    Raises an error if it is unsound, or a link out of its folder.
    """
    use_timing_formats({})
    pack = load_project(path)
    if faults := [*check_timing_formats(pack)]:
        raise PackFaults(faults)
    use_timing_formats(timing_formats(pack.model))
    return pack


def timing_formats(project: Project) -> TimingFormats:
    """Return the formats of a project as plain data, which workers receive."""
    stated = project.timing_formats.items()
    return {name: one.model_dump(exclude_none=True) for name, one in stated}


def use_timing_formats(formats: TimingFormats) -> None:
    """Let files be read in these formats, and no longer in those of an earlier project."""
    from lipsync_lang.schedules.records import record_format
    from lipsync_lang.schedules.timing_readers import TIMING_READERS

    TIMING_READERS.drop(FILE)
    for name, fields in formats.items():
        TIMING_READERS.add(name, record_format(name, fields).reader(), FILE)


def check_timing_formats(pack: Pack[Project]) -> Iterator[Fault]:
    """Yield a fault for each format with the name of one that the program or a plug-in has."""
    if not pack.model.timing_formats:
        return
    from lipsync_lang.schedules.timing_readers import TIMING_READERS

    for name in sorted(pack.model.timing_formats.keys() & TIMING_READERS.beside(FILE)):
        what = f"there is a format '{name}' already"
        yield pack.fault(("timing_formats", name), "P106", what, "choose another name", key=True)
