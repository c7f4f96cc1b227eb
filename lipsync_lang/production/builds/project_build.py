"""A project in a build: its lines, its pairs, its settings and its record."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from fractions import Fraction
from pathlib import Path
from typing import Self

import numpy as np

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.errors import LipsyncError, OutputError, shortlist
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.project import FILE, find_project, load_project
from lipsync_lang.packs.yaml.faults import Fault, PackFaults
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.production.builds.adapted_models import adapted_pair
from lipsync_lang.production.builds.archives import split_archive
from lipsync_lang.production.builds.faces import GLB
from lipsync_lang.production.builds.making import LineMaker
from lipsync_lang.production.builds.needs import BuildSettings, PairNeeds
from lipsync_lang.production.builds.planned_line import BuiltLine, PlannedLine
from lipsync_lang.production.builds.planning import BuildPlan, plan
from lipsync_lang.production.builds.project_extras import check_installed
from lipsync_lang.production.builds.records import Records
from lipsync_lang.production.builds.script import read_script
from lipsync_lang.production.builds.script_faults import PlanningError, ScriptFaults
from lipsync_lang.production.builds.script_files import PlanRemark
from lipsync_lang.production.builds.shards import Shard
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.sound.speech.needed_extras import missing_for

STILL_SCHEDULE = Schedule((SILENCE,), np.array((0.0, 0.1)))
"""Schedule without a phoneme."""

SHOWN_CHARACTERS = 8
"""Maximum number of characters that a fault names."""

USUAL_FPS = 60.0
"""Default frame rate of a project in frames per second."""

PairNames = tuple[str, str]
"""Language and character."""


@dataclass(frozen=True)
class Selection:
    """The lines of a project that a build is about; an empty field selects all."""

    ids: tuple[str, ...] = ()
    """Patterns of ids, such as ``intro_*``."""
    languages: tuple[str, ...] = ()
    characters: tuple[str, ...] = ()
    shard: Shard | None = None

    def has(self, line: PlannedLine) -> bool:
        """Return True if a line is selected."""
        return (
            (not self.languages or line.language in self.languages)
            and (not self.characters or line.character in self.characters)
            and (not self.ids or any(fnmatchcase(line.name, one) for one in self.ids))
            and (self.shard is None or self.shard.has(line.language, line.name))
        )

    def of(self, lines: Iterable[PlannedLine]) -> list[PlannedLine]:
        """Return the selected lines; a shard writes archives of its own."""
        chosen = [line for line in lines if self.has(line)]
        if self.shard is None:
            return chosen
        return [
            replace(line, outputs=tuple((w, self.shard.output(path)) for w, path in line.outputs))
            for line in chosen
        ]

    def __bool__(self) -> bool:
        return bool(self.ids or self.languages or self.characters)


@dataclass
class ProjectBuild:
    """A project that is read, with its pairs resolved."""

    project: Project
    folder: Path
    lines: list[PlannedLine]
    settings: BuildSettings
    pairs: dict[PairNames, PairNeeds]
    unsound: dict[PairNames, LipsyncError] = field(default_factory=dict)
    """Pairs whose packs have faults, with the faults."""
    selection: Selection = field(default_factory=Selection)

    @classmethod
    def open(  # noqa: PLR0913 a project and options
        cls,
        file: Path | None = None,
        *,
        paths: Iterable[Path] = (),
        selection: Selection | None = None,
        tts: str | None = None,
        remark: PlanRemark = lambda _: None,
        adapt: bool = False,
    ) -> Self:
        """Read a project and its script, and resolve its pairs.

        Parameters
        ----------
        file : the project's file; None for the one of the current folder
        paths : folders of packs to search first
        tts : another speech engine than the languages'
        remark : where to say what the script lacks
        adapt : True to adapt acoustic models, if the project asks for it

        Raises
        ------
        LipsyncError
            There is no project, or it or its script is faulty.
        """
        found = file or find_project()
        if found is None:
            raise LipsyncError(
                f"this folder has no {FILE}; `lipsync-lang new NAME` makes a folder with one"
            )
        pack = load_project(found)
        project, folder = pack.model, found.absolute().parent
        chosen = Selection() if selection is None else selection
        faults = ScriptFaults(pack)
        places = (*paths, *(folder / path for path in project.paths))
        unread = missing_for({path: [Path(path).suffix.lower()] for path in project.lines})
        read = () if unread else read_script(pack, paths=tuple(paths), remark=remark)
        lines = chosen.of(read)
        if chosen and not lines and not unread:
            raise LipsyncError("no line of the script is selected; check the ids and names")
        library = Library(places, folder)
        check_installed(faults, project, library, None if unread else lines, tts)
        faults.raise_any()
        fps = float(Fraction(project.fps)) if project.fps is not None else USUAL_FPS
        once = project.glb.face == "once"
        settings = BuildSettings(
            fps, dict(project.limits), tts, project.gestures, project.idle or 0.0,
            project.offset or 0.0, once,
        )  # fmt: skip
        made = cls(project, folder, lines, settings, {}, {}, chosen)
        made.resolve((*places, folder))
        if adapt and project.adapt:
            made.adapt(read, remark)
        made.check_outputs(faults)
        faults.raise_any()
        weak: dict[str, None] = {}  # unreliable readings of languages, for lines without timings
        for line in lines:
            needs = made.pairs.get((line.language, line.character))
            if line.timings is None and needs and (why := needs.performer.speaker.manner.weak):
                weak[why] = None
        for why in weak:
            remark(why)
        return made

    def resolve(self, paths: Iterable[Path]) -> None:
        """Resolve every pair of the lines; set pairs with faults aside for the report."""
        motion = self.project.motion
        stated = None if motion is None else motion.model_dump(exclude_none=True)
        for language, character in dict.fromkeys(
            (one.language, one.character) for one in self.lines
        ):
            try:
                performer = resolve(
                    language,
                    character,
                    paths=tuple(paths),
                    motion=stated,
                    shades=self.project.shades,
                )
                self.pairs[language, character] = PairNeeds(performer, self.settings)
            except LipsyncError as error:
                self.unsound[language, character] = error

    def adapt(self, lines: Sequence[PlannedLine], remark: PlanRemark) -> None:
        """Adapt the acoustic model of each language to its recordings in the whole script."""
        for (language, character), pair in self.pairs.items():
            own = [line for line in lines if line.language == language]
            self.pairs[language, character] = adapted_pair(pair, self.folder, own, remark)

    def check_outputs(self, faults: ScriptFaults) -> None:
        """Refuse outputs that a format cannot hold, tried with each character at rest."""
        refused: dict[tuple[int, str], list[str]] = {}
        tried: set[str] = set()
        for line in self.lines:
            pair = self.pairs.get((line.language, line.character))
            if pair is None or line.character in tried:
                continue
            tried.add(line.character)
            at_rest = pair.performer.rigged(
                pair.performer.perform(STILL_SCHEDULE, self.settings.fps)
            )
            for number, (name, path) in enumerate(line.outputs):
                try:
                    if self.settings.face_once and name == GLB and split_archive(path):
                        what = "an archive cannot share a face; remove `glb`, or write files"
                        raise OutputError(what)
                    WRITERS[name].refuse(at_rest)
                except LipsyncError as error:
                    refused.setdefault((number, str(error)), []).append(line.character)
        for (number, why), characters in refused.items():
            named = shortlist(characters, SHOWN_CHARACTERS)
            faults.state(("outputs", number), "P405", f"cannot be made on {named}: {why}")

    @property
    def maker(self) -> LineMaker:
        """The maker of its lines."""
        return LineMaker(self.folder, self.settings)

    def plan(
        self,
        records: Records,
        *,
        force: bool = False,
        overwrite: bool = False,
    ) -> BuildPlan:
        """Compare the lines with the record of the last build; see `planning.plan`."""
        sound = [line for line in self.lines if (line.language, line.character) in self.pairs]
        made = plan(
            sound,
            self.folder,
            records,
            self.pairs,
            force=force,
            overwrite=overwrite,
        )
        stated = {line.key for line in self.lines}
        gone = tuple(one for one in made.gone if not self.selection and one[0] not in stated)
        return replace(made, gone=gone)

    def refused(self) -> list[BuiltLine]:
        """Return the lines of pairs whose packs have faults, as failed."""
        return [
            BuiltLine(
                line,
                "failed",
                f"{line.place}: {line.language} on {line.character} has faults in its packs",
            )
            for line in self.lines
            if (line.language, line.character) in self.unsound
        ]


def planning_faults(file: Path, paths: Iterable[Path] = ()) -> list[Fault]:
    """Return what keeps a project from being built, and warnings, as a build finds them."""
    found: list[Fault] = []
    pack = load_project(file)

    def keep(remark: str | Fault) -> None:
        found.extend([remark] if isinstance(remark, Fault) else [])

    try:
        unsound = ProjectBuild.open(file, paths=paths, remark=keep).unsound
    except PlanningError as error:
        told = [pack.fault(("lines",), "P407", one) for one in error.told]
        found += [*error.stated, *told]
        # A project without a script serves commands of single lines.
        return found if pack.model.lines else [one for one in found if one.code == "P404"]
    reasons: dict[str, list[str]] = {}
    for (language, character), why in unsound.items():
        if isinstance(why, PackFaults):
            found += why.faults
        else:
            reasons.setdefault(str(why), []).append(f"{language} on {character}")
    for reason, pairs in reasons.items():
        what = f"cannot perform {shortlist(pairs, SHOWN_CHARACTERS)}: {reason}"
        found.append(pack.fault(("languages",), "P408", what))
    return found
