"""Lines of a build, read from the script that a project states.

Faults of the script are collected, each with its place, and raised together. Lines that are left
out or lack a file are not faults: remarks count them.
"""

from pathlib import Path

from lipsync_lang.build.casting import Cast, languages_of
from lipsync_lang.build.output_paths import check_links, check_outputs, outputs_of
from lipsync_lang.build.planned_line import CONFIDENCE, PlannedLine
from lipsync_lang.build.script_faults import ScriptFaults
from lipsync_lang.build.script_files import Remark, ScriptFile, ScriptLanguage, read_rows
from lipsync_lang.build.script_lines import ScriptPlanner
from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.lines.line_readers import line_files
from lipsync_lang.lines.markup import Cleaning
from lipsync_lang.packs.finding import Finder, Paths, folders_of
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.project import FILE
from lipsync_lang.packs.yaml.faults import shown

REPORT_SUFFIXES = (".html", ".xml", ".json")


def read_script(
    project: Project,
    folder: Path,
    *,
    paths: Paths = (),
    remark: Remark | None = None,
) -> list[PlannedLine]:
    """Read the lines that a project states, in every language and on every character.

    Parameters
    ----------
    project : the project; its `lines` and `outputs` are needed
    folder : the project's folder, which its paths are meant from
    paths : folders of packs to search before those of the project
    remark : where to say what is left out or missing, in counts

    Returns
    -------
    The lines in the order of the script; each has its own outputs.

    Raises
    ------
    LipsyncError
        The script or the project is faulty; the message lists the first faults with their places.

    Examples
    --------
    >>> project = Project.model_validate(data)  # doctest: +SKIP
    >>> read_script(project, Path("game"))[0].outputs  # doctest: +SKIP
    (('csv', 'takes/english/facefx/intro_001.csv'),)
    """
    faults = ScriptFaults()
    own = [folder / path for path in project.paths]
    finder = Finder([*folders_of(paths), *own], folder)
    languages = languages_of(project, finder, faults)
    cast = Cast(project, finder, faults)
    outputs = outputs_of(project, faults)
    several = {"{id}": "all lines"}
    several |= {"{language}": "all languages"} if len(languages) > 1 else {}
    several |= {"{character}": "all characters of a line"} if cast.most > 1 else {}
    check_outputs(outputs, several, faults)
    check_links({output.path for output in outputs}, folder, faults)
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
    if not faults:
        planner.check_clashes(planned, [folder / FILE, *(file.path for file in files)])
    faults.raise_any()
    planner.tell(tell)
    return planned


def _check_settings(project: Project, faults: ScriptFaults) -> None:
    """Check the settings of other parts of a build before hours of work."""
    if not project.lines:
        faults.add(FILE, "states no `lines`; name the table of the script, such as script.csv")
    if project.limits:
        from lipsync_lang.quality.measures import load_measures

        known = {*load_measures(), CONFIDENCE}
        for name in project.limits.keys() - known:
            faults.add(FILE, f"limits: unknown measure '{name}'; {did_you_mean(name, known)}")
    for report in project.reports:
        if not report.lower().endswith(REPORT_SUFFIXES):
            ends = ", ".join(REPORT_SUFFIXES)
            faults.add(FILE, f"reports: unknown format of '{report}'; use one of {ends}")


def _files(
    project: Project,
    folder: Path,
    languages: dict[int, ScriptLanguage],
    faults: ScriptFaults,
    remark: Remark,
) -> list[ScriptFile]:
    """List the files of the script; those of one language are read once for each."""
    found: list[ScriptFile] = []
    cleaning = Cleaning(project.values, project.unspoken)
    for stated in project.lines:
        own = [{index: language} for index, language in languages.items()]
        for held in own if "{language}" in stated else [languages]:
            path = folder / stated.replace("{language}", next(iter(held.values())).word)
            try:
                for file, among_others in line_files(Path(shown(path)), remark):
                    found.append(ScriptFile(file, held, project.encoding, among_others, cleaning))
            except LipsyncError as error:
                faults.add_error(error)
    return found
