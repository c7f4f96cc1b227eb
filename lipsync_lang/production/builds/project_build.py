"""A project in a build: its lines, its pairs, its settings and its record.

Shards are disjoint parts of a project that machines build with nothing shared but its folder. A
line belongs to a shard by its id and language, so it stays there when others come and go, and all
characters share its timings. Archives and the record of a shard have names of their own.

Acoustic models are adapted to the recordings of a project, one for each language. A model is found
by the digest of all that it depends on, so that a build adapts once, and again when a recording or
a text changes. It is a folder of the cache (decision 0002).
"""

import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from fractions import Fraction
from pathlib import Path, PurePath
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any, Self
from zlib import crc32

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.animations.rates import USUAL_FPS
from lipsync_lang.base.errors import LipsyncError, OutputError, shortlist
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.files.writing import replace_file
from lipsync_lang.packs.checking.voices import check_voices, lacks_voice
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.project import FILE, find_project, load_project
from lipsync_lang.packs.yaml.faults import Fault, PackFaults
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.production.builds import timing_formats
from lipsync_lang.production.builds.archives import split_archive
from lipsync_lang.production.builds.digests import digest, file_digest
from lipsync_lang.production.builds.faces import GLB
from lipsync_lang.production.builds.making import LineMaker
from lipsync_lang.production.builds.needs import BuildSettings, PairNeeds
from lipsync_lang.production.builds.output_paths import writer_of
from lipsync_lang.production.builds.planned_line import BuiltLine, PlannedLine
from lipsync_lang.production.builds.planning import BuildPlan, plan
from lipsync_lang.production.builds.records import Records
from lipsync_lang.production.builds.script import read_script
from lipsync_lang.production.builds.script_faults import PlanningError, ScriptFaults
from lipsync_lang.production.builds.script_files import PlanRemark
from lipsync_lang.production.builds.timing import TIMERS
from lipsync_lang.resolver.cache import compiler, folder
from lipsync_lang.schedules.schedule import AT_REST
from lipsync_lang.sound.speech.needed_extras import engines_of, missing_for, missing_words
from lipsync_lang.text.phonology.manner import Manner

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project
    from lipsync_lang.sound.speech.hearing.adaptation import SpokenFile
    from lipsync_lang.sound.speech.hearing.sphinx.folder import Models

NONE_KNOWN: Mapping[str, Manner] = {}

SHOWN_CHARACTERS = 8
"""Maximum number of characters that a fault names."""

PairNames = tuple[str, str]
"""Language and character."""

MAX_KEPT_MODELS = 16
"""Maximum number of models in the cache; the oldest are deleted first. Each has some 10 MB."""

POCKETSPHINX = "pocketsphinx"
"""Name of the aligner with acoustic models."""

UNCHANGED = "gains-nothing"
"""Ending of a file in place of a model that would gain nothing."""

AdaptationRemark = Callable[[str], None]
"""A function that takes the result of an adaptation, in words."""


@dataclass(frozen=True)
class Shard:
    """A part of a project."""

    number: int
    """From 1."""
    parts: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Parse ``3/16``; raises LipsyncError.

        >>> Shard.parse("3/16")
        Shard(number=3, parts=16)
        """
        number, _, count = text.partition("/")
        if number.isascii() and number.isdecimal() and count.isascii() and count.isdecimal():
            found = cls(int(number), int(count))
            if 1 <= found.number <= found.parts:
                return found
        raise LipsyncError(f"--shard {text}: give a part and the number of parts, such as 3/16")

    @property
    def name(self) -> str:
        """Its name in paths."""
        return f"{self.number}-of-{self.parts}"

    def has(self, language: str, line: str) -> bool:
        """Return True if a line belongs to the shard."""
        return crc32(f"{language}/{line}".encode()) % self.parts == self.number - 1

    def named(self, path: str) -> str:
        """Return a path with the shard in the name of its file.

        >>> Shard(3, 16).named("takes/crab.takes")
        'takes/crab.3-of-16.takes'
        """
        pure = PurePath(path)
        return pure.with_name(f"{pure.stem}.{self.name}{pure.suffix}").as_posix()

    def output(self, path: str) -> str:
        """Return an output of the shard; only archives have other names than in a whole build."""
        split = split_archive(path)
        return path if split is None else f"{self.named(split[0])}/{split[1]}"


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

    project: "Project"
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

        Raises LipsyncError if there is no project, or it or its script is faulty.

        Parameters
        ----------
        file : the project's file; None for the one of the current folder
        paths : folders of packs to search first
        tts : another speech engine than the languages'
        remark : where to say what the script lacks
        adapt : True to adapt acoustic models, if the project asks for it
        """
        found = file or find_project()
        if found is None:
            raise LipsyncError(
                f"this folder has no {FILE}; `lipsync-lang new NAME` makes a folder with one"
            )
        pack = timing_formats.open_project(found)
        project, folder = pack.model, found.absolute().parent
        chosen = Selection() if selection is None else selection
        faults = ScriptFaults(pack)
        places = (*paths, *(folder / path for path in project.paths))
        # A spreadsheet without its library is told together with all that is missing, below.
        unread = missing_for({path: [Path(path).suffix.lower()] for path in project.lines})
        read = () if unread else read_script(pack, paths=tuple(paths), remark=remark)
        lines = chosen.of(read)
        if chosen and not lines and not unread:
            raise LipsyncError("no line of the script is selected; check the ids and names")
        library = Library(places, folder)
        fps = float(Fraction(project.fps)) if project.fps is not None else USUAL_FPS
        stated_fps = None if project.fps is None else fps
        once = project.glb.face == "once"
        formats = timing_formats.plain_formats(project.timing_formats)
        settings = BuildSettings(
            fps, dict(project.limits), tts, project.gestures, project.idle or 0.0,
            project.offset or 0.0, once, formats, stated_fps,
        )  # fmt: skip
        made = cls(project, folder, lines, settings, {}, {}, chosen)
        made.resolve((*places, folder))
        made.check_installed(faults, library, None if unread else lines, tts)
        faults.raise_any()
        if adapt and project.adapt:
            made.adapt(read, remark)
        made.check_outputs(faults)
        faults.raise_any()
        untimed = {(one.language, one.character) for one in lines if one.timings is None}
        spoken = [pair for names, pair in made.pairs.items() if names in untimed]
        weak = dict.fromkeys(pair.performer.speaker.manner.weak for pair in spoken)
        for why in filter(None, weak):  # unreliable readings of languages
            remark(why)
        return made

    def resolve(self, paths: Iterable[Path]) -> None:
        """Resolve every pair of the lines; set pairs with faults aside for the report."""
        motion = self.project.motion
        stated = None if motion is None else motion.model_dump(exclude_none=True)
        asked: dict[str, Any] = {"paths": (*paths,), "motion": stated}
        for pair in dict.fromkeys((one.language, one.character) for one in self.lines):
            try:
                performer = resolve(*pair, shades=self.project.shades, **asked)
                self.pairs[pair] = PairNeeds(performer, self.settings)
            except LipsyncError as error:
                self.unsound[pair] = error

    def adapt(self, lines: Sequence[PlannedLine], remark: PlanRemark) -> None:
        """Adapt the acoustic model of each language to its recordings in the whole script."""
        for (language, character), pair in self.pairs.items():
            own = [line for line in lines if line.language == language]
            self.pairs[language, character] = adapted_pair(pair, self.folder, own, remark)

    def check_installed(
        self,
        faults: ScriptFaults,
        library: Library,
        lines: Iterable[PlannedLine] | None,
        tts: str | None,
    ) -> None:
        """Add a fault for all missing packages that a project needs, and for each wrong voice."""
        untimed = {line.language for line in lines or () if line.timings is None}
        known = {
            language: pair.performer.speaker.manner
            for (language, _), pair in self.pairs.items()
            if language in untimed
        }
        needed = extras_of_project(self.project, library, lines, tts, known)
        if missing := missing_for(needed):
            what, hint = missing_words(missing), f"install them: {install_line(*missing)}"
            faults.state(("languages",), "P406", what, hint)
        named = sorted(needed.keys() - {*self.project.lines, *self.project.outputs})
        doubted = [name for name in named if name not in known or lacks_voice(known[name])]
        # A look-up of a name that is no language reads the head of every pack.
        found = [name for name in doubted if library.lookup("language", name)]
        faults.stated += check_voices(map(library.language, found))

    def check_outputs(self, faults: ScriptFaults) -> None:
        """Refuse outputs that a format cannot hold, tried with each character at rest."""
        refused: dict[tuple[int, str], list[str]] = {}
        tried: set[str] = set()
        for line in self.lines:
            pair = self.pairs.get((line.language, line.character))
            if pair is None or line.character in tried:
                continue
            # One line of each character: its face decides what a format can hold, not the text.
            tried.add(line.character)
            at_rest = pair.performer.rigged(pair.performer.perform(AT_REST, self.settings.fps))
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

    def plan(self, records: Records, *, force: bool = False, overwrite: bool = False) -> BuildPlan:
        """Compare the lines with the record of the last build; see `planning.plan`."""
        sound = [line for line in self.lines if (line.language, line.character) in self.pairs]
        made = plan(sound, self.folder, records, self.pairs, force=force, overwrite=overwrite)
        stated = {line.key for line in self.lines} if made.gone else ()
        gone = tuple(one for one in made.gone if not self.selection and one[0] not in stated)
        return replace(made, gone=gone)

    def refused(self) -> list[BuiltLine]:
        """Return the lines of pairs whose packs have faults, as failed."""
        told = "{0.place}: {0.language} on {0.character} has faults in its packs".format
        lost = (one for one in self.lines if (one.language, one.character) in self.unsound)
        return [BuiltLine(one, "failed", told(one)) for one in lost]


def planning_faults(file: Path, paths: Iterable[Path] = ()) -> list[Fault]:
    """Return what keeps a project from being built, and warnings, as a build finds them."""
    pack = load_project(file)
    if found := [*timing_formats.check_timing_formats(pack)]:
        return found

    def keep(remark: str | Fault) -> None:
        found.extend([remark] if isinstance(remark, Fault) else [])

    try:
        build = ProjectBuild.open(file, paths=paths, remark=keep)
    except PlanningError as error:
        told = [pack.fault(("lines",), "P407", one) for one in error.told]
        found += [*error.stated, *told]
        # A project without a script serves commands of single lines.
        return found if pack.model.lines else [one for one in found if one.code == "P404"]
    reasons: dict[str, list[str]] = {}
    timed = map(Path, sorted({line.timings for line in build.lines if line.timings}))
    found += timing_formats.check_files(pack, timed)
    for (language, character), why in build.unsound.items():
        if isinstance(why, PackFaults):
            found += why.faults
        else:
            reasons.setdefault(str(why), []).append(f"{language} on {character}")
    for reason, pairs in reasons.items():
        what = f"cannot perform {shortlist(pairs, SHOWN_CHARACTERS)}: {reason}"
        found.append(pack.fault(("languages",), "P408", what))
    return found


def file_faults(files: Iterable[Path]) -> list[Fault]:
    """Return where formats of this folder's project do not fit files; LipsyncError without any."""
    project = find_project()
    pack = None if project is None else timing_formats.open_project(project)
    for path in files:
        if pack is None or not timing_formats.formats_for(pack.model, path):
            raise LipsyncError(
                f"{path}: no pack, and the project here has no `timing_formats` or "
                "`script_formats` for it; check the path, or state a format"
            )
    return [] if pack is None else [*timing_formats.check_files(pack, files)]


def adapted_pair(
    pair: PairNeeds, home: Path, lines: Sequence[PlannedLine], remark: AdaptationRemark
) -> PairNeeds:
    """Return a pair whose aligner has a model that knows the voices of some lines.

    Without enough recordings, or if the model gains nothing, it is the same pair.
    """
    manner = pair.performer.compiled.manner
    aligners = manner["audio"]["align"]
    if not any(name.partition(":")[0] == POCKETSPHINX for name in aligners):
        return pair
    try:
        path = _adapted_folder(pair, home, lines, remark)
    except (LipsyncError, OSError) as error:
        remark(f"{manner['language']}: the acoustic model was not adapted: {error}")
        return pair
    if path is None:
        return pair
    named = [
        f"{POCKETSPHINX}:{path}" if name.partition(":")[0] == POCKETSPHINX else name
        for name in aligners
    ]
    changed = manner | {"audio": manner["audio"] | {"align": named}}
    compiled = replace(pair.performer.compiled, manner=changed)
    return PairNeeds(replace(pair.performer, compiled=compiled), pair.settings)


def _adapted_folder(
    pair: PairNeeds, home: Path, lines: Sequence[PlannedLine], remark: AdaptationRemark
) -> Path | None:
    """Return the folder of the adapted model, made first if the cache lacks it."""
    from lipsync_lang.sound.speech.hearing.adaptation import SpokenFile
    from lipsync_lang.sound.speech.hearing.align.pocketsphinx_aligner import models_of

    where = folder()
    if where is None:
        raise LipsyncError("the cache is off, and adapted models are kept there")
    audio = pair.performer.speaker.manner.audio
    named = next(one for one in audio.align if one.partition(":")[0] == POCKETSPHINX)
    model = named.partition(":")[2] or (audio.model if named == audio.align[0] else None)
    models = models_of(model)
    spoken = [
        SpokenFile(home / one.audio, one.text)
        for one in {line.audio: line for line in lines}.values()
        if one.audio is not None and one.text and one.timings is None
    ]
    told = [(file_digest(one.path), one.text) for one in spoken if one.path.is_file()]
    base = [file_digest(path) for path in sorted(models.acoustic.iterdir()) if path.is_file()]
    name = digest(pair.speech.hex(), sorted(told), base, compiler(TIMERS)).hex()
    path = where / "models" / name
    if not path.is_dir() and not path.with_suffix(f".{UNCHANGED}").exists():
        _make(pair, spoken, models, path, remark)
    return path if path.is_dir() else None


def _make(
    pair: PairNeeds,
    spoken: "Sequence[SpokenFile]",
    models: "Models",
    path: Path,
    remark: AdaptationRemark,
) -> None:
    """Adapt a model into a folder of the cache, or mark there that it gains nothing."""
    from lipsync_lang.sound.speech.hearing.adaptation import adapt, write_adapted

    speaker = pair.performer.speaker
    found = adapt(speaker, spoken, models)
    rise = f"log likelihood of held-out frames {found.before:.2f} to {found.after:.2f}"
    told = f"{speaker.manner.language}: acoustic model adapted to {found.lines} lines, {rise}"
    remark(told if found.gains else f"{told}: it gains nothing, and stays as it was")
    for line in found.left_out:
        remark(f"{speaker.manner.language}: not adapted to {line}")
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not found.gains:
        path.with_suffix(f".{UNCHANGED}").touch()
        return
    # made beside its place and moved there whole
    made = Path(mkdtemp(dir=path.parent)) / path.name
    write_adapted(models, found.model, made)
    if not path.exists():
        replace_file(made, path)
    shutil.rmtree(made.parent)
    folders = (one for one in path.parent.iterdir() if one.is_dir())
    kept = sorted(folders, key=lambda one: one.stat().st_mtime)
    for old in kept[:-MAX_KEPT_MODELS]:
        shutil.rmtree(old, ignore_errors=True)


def extras_of_project(
    project: "Project",
    library: Library,
    lines: Iterable[PlannedLine] | None = None,
    tts: str | None = None,
    known: Mapping[str, Manner] = NONE_KNOWN,
) -> dict[str, list[str]]:
    """Map languages and files of a project to what they need, for `missing_for`.

    Parameters
    ----------
    lines : the lines to make; None if they are unknown, so that any language may be spoken
    tts : a speech engine in place of the languages'
    known : languages whose packs need not be read
    """
    needed = {stated: [Path(stated).suffix.lower()] for stated in project.lines}
    for stated in project.outputs:
        try:
            needed[stated] = [writer_of(stated)[0]]
        except OutputError:
            continue  # another check refuses it
    heard: dict[str, set[bool]] = {}
    if lines is None:
        names = project.languages or ([project.language] if project.language else [])
        heard = {name: {False, bool(project.audio)} for name in names}
    for line in lines or ():
        if line.timings is None:
            heard.setdefault(line.language, set()).add(line.audio is not None)
    for name, ways in heard.items():
        manner = known.get(name) or _read_manner(library, name)
        needed[name] = [*engines_of(manner, spoken=False in ways, heard=True in ways, tts=tts)]
    return needed


def _read_manner(library: Library, name: str) -> Manner:
    from lipsync_lang.resolver.language_tables import manner_of

    return manner_of(library.language(name), library.common().model)
