"""Lines of a build, read from the script that a project states.

Faults of the script are collected, each with its place, and raised together. Lines that are left
out or lack a file are not faults: remarks count them.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.packs.checking.project_checks import check_characters, check_languages
from lipsync_lang.packs.finding import Finder, Paths, folders_of
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.yaml.faults import shown
from lipsync_lang.production.builds.output_paths import check_links, check_shared, outputs_of
from lipsync_lang.production.builds.planned_line import CONFIDENCE, PlannedLine
from lipsync_lang.production.builds.script_faults import ScriptFaults
from lipsync_lang.production.builds.script_files import (
    PlanRemark,
    ScriptFile,
    ScriptLanguage,
    read_rows,
)
from lipsync_lang.production.builds.script_lines import Cast, ScriptPlanner, languages_of
from lipsync_lang.text.lines.line_readers import line_files
from lipsync_lang.text.lines.markup import Cleaning

if TYPE_CHECKING:
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.source import Loc

REPORT_SUFFIXES = (".html", ".xml", ".json")


def read_script(
    pack: "Pack[Project]", *, paths: Paths = (), remark: PlanRemark | None = None
) -> list[PlannedLine]:
    """Read the lines that a project states, in every language and on every character.

    Parameters
    ----------
    pack : the project; its `lines` and `outputs` are needed, and its paths start at its folder
    paths : folders of packs to search before those of the project
    remark : where to say what is left out or missing, in counts

    Returns
    -------
    The lines in the order of the script; each has its own outputs.

    Raises
    ------
    PlanningError
        The script or the project is faulty; the message lists the first faults with their places.

    Examples
    --------
    >>> read_script(load_project(Path("game/lipsync.yaml")))[0].outputs  # doctest: +SKIP
    (('csv', 'takes/english/facefx/intro_001.csv'),)
    """
    project, folder, faults = pack.model, pack.path.absolute().parent, ScriptFaults(pack)
    own = [folder / path for path in project.paths]
    finder = Finder([*folders_of(paths), *own], folder)
    faults.stated += [*check_languages(pack, finder), *check_characters(pack, finder)]
    languages = languages_of(project, finder, faults)
    cast = Cast(project, finder, faults)
    outputs = outputs_of(project, faults)
    several = {"{id}": "all lines"}
    several |= {"{language}": "all languages"} if len(languages) > 1 else {}
    sources: list[tuple[Loc, str | None]] = [
        (("audio",), project.audio), (("timings",), project.timings),
    ]  # fmt: skip
    check_shared([(loc, path) for loc, path in sources if path], several, faults)
    several |= {"{character}": "all characters of a line"} if cast.most > 1 else {}
    check_shared([(output.loc, output.path) for output in outputs], several, faults)
    check_links([(output.loc, output.path) for output in outputs], folder, faults)
    reports = enumerate(project.reports)
    check_links([(("reports", number), path) for number, path in reports], folder, faults)
    _check_settings(project, faults)
    faults.raise_any()
    tell = remark or (lambda _: None)
    planner = ScriptPlanner(project, folder, languages=languages, cast=cast, outputs=outputs)
    files = _files(project, folder, languages, faults, tell)
    planned = [
        line
        for file in files
        for row in read_rows(file, project.columns, faults, tell)
        for line in planner.lines(file, row)
    ]
    cast.check_speakers()
    if not faults:
        planner.check_clashes(planned, [pack.path.absolute(), *(file.path for file in files)])
        planner.check_recordings()
    faults.raise_any()
    for warning in faults.stated:
        tell(warning)
    planner.tell(tell)
    return planned


def _check_settings(project: Project, faults: ScriptFaults) -> None:
    """Check the settings of other parts of a build before hours of work."""
    if not project.lines:
        hint = "name the table of the script, such as `lines: script.csv`"
        faults.state((), "P401", "no `lines`", hint)
    if project.limits:
        from lipsync_lang.reports.quality.measures import load_measures

        known = {*load_measures(), CONFIDENCE}
        for name in project.limits.keys() - known:
            what = f"unknown measure '{name}'"
            faults.state(("limits", name), "P404", what, did_you_mean(name, known))
    for number, report in enumerate(project.reports):
        if not report.lower().endswith(REPORT_SUFFIXES):
            ends = ", ".join(REPORT_SUFFIXES)
            what = f"unknown format of the report '{report}'"
            faults.state(("reports", number), "P404", what, f"use one of {ends}")


def _files(
    project: Project,
    folder: Path,
    languages: dict[int, ScriptLanguage],
    faults: ScriptFaults,
    remark: PlanRemark,
) -> list[ScriptFile]:
    """List the files of the script; those of one language are read once for each."""
    found: list[ScriptFile] = []
    cleaning = Cleaning(project.values, project.unspoken)
    for stated in project.lines:
        own = [{index: language} for index, language in languages.items()]
        for held in own if "{language}" in stated else [languages]:
            path = folder / stated.replace("{language}", next(iter(held.values())).word)
            try:
                for file, among_others in line_files(Path(shown(path)), remark, project=folder):
                    found.append(ScriptFile(file, held, project.encoding, among_others, cleaning))
            except LipsyncError as error:
                faults.add_error(error)
    return found
