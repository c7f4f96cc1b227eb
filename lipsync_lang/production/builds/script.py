"""Lines of a build, read from the script that a project states.

Faults of the script are collected, each with its place, and raised together. Lines that are left
out or lack a file are not faults: remarks count them.
"""

import errno
import os
import posixpath
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from lipsync_lang.base.errors import LipsyncError, count, did_you_mean, shortlist
from lipsync_lang.base.files.names import BRACES, fault_of_name, fill, folded_name
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.packs.checking.project_checks import check_characters, check_languages
from lipsync_lang.packs.finding import Finder, Paths, folders_of, pack_name
from lipsync_lang.packs.language_files import spoken_in
from lipsync_lang.packs.project import FILE
from lipsync_lang.packs.speaker_faces import OTHERS, SpeakerFaces, stated_faces, unique
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.production.builds.output_paths import (
    OutputPattern,
    check_links,
    check_shared,
    filled,
    for_line,
    outputs_of,
)
from lipsync_lang.production.builds.planned_line import CONFIDENCE, PlannedLine
from lipsync_lang.production.builds.script_faults import ScriptFaults
from lipsync_lang.production.builds.script_files import (
    PlanRemark,
    ScriptFile,
    ScriptLanguage,
    ScriptRow,
    read_apart,
)
from lipsync_lang.text.lines.cleaning import Cleaning
from lipsync_lang.text.lines.line_readers import LineFile, is_timed, line_files
from lipsync_lang.text.lines.plain import TIMING_SUFFIXES

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.source import Loc

REPORT_SUFFIXES = (".html", ".xml", ".json")

SHOWN_EXAMPLES = 3
"""Maximum number of examples in a remark."""

ALL = -1
"""Index that stands for all languages."""

LACKING = {
    "text": "without text, left out",
    "recording": "without a recording, so a voice speaks",
    "timings": "without the stated timings",
}
"""Kinds of gaps, and their words after the number of lines."""

NO_FOLDER = frozenset((errno.ENOENT, errno.ENAMETOOLONG, errno.EINVAL))
"""Errors of a folder that is not there, or cannot be; every other folder has to be readable."""

COMMON_SUFFIXES = {".csv", ".dat", ".json", ".jsonl", ".lab", ".tsv", ".txt", ".xml"}
"""Suffixes of timings that other files have too; the content decides."""

RARE_SUFFIXES = tuple(sorted({*TIMING_SUFFIXES} - COMMON_SUFFIXES))
"""Suffixes of timings only."""


def languages_of(
    project: "Project", finder: Finder, faults: ScriptFaults
) -> dict[int, ScriptLanguage]:
    """Return the languages of a build by their index."""
    stated = project.languages or ({project.language: None} if project.language else {})
    if not stated:
        faults.state((), "P401", "no `languages`", "state `languages: [NAME, ...]`")
    found: dict[int, ScriptLanguage] = {}
    for own, word in stated.items():
        name = finder.language_of(own) or own  # ENGINE:CODE has no pack
        names = finder.column_names(own, word)
        found[len(found)] = ScriptLanguage(name, word or own.replace(":", "-"), names)
    return found


class Cast:
    """The characters of each speaker."""

    def __init__(self, project: "Project", finder: Finder, faults: ScriptFaults) -> None:
        stated = stated_faces(project)
        if not stated:
            hint = "state `character: NAME` or `cast: {...}`"
            faults.state((), "P401", "no `character`", hint)
        faces: dict[str, tuple[str, ...]] = {}
        for speaker, names in stated.items():
            own: list[str] = []
            for name in names:
                found = finder.lookup("character", name) or finder.lookup("poseset", name)
                # an unknown one is a fault of `check_characters`
                own += map(pack_name, map(Path, found[:1]))
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


class Examples:
    """Count of a thing, with the first few of it."""

    def __init__(self) -> None:
        self.count = 0
        self.first: list[str] = []

    def add(self, one: str) -> None:
        """Count one more."""
        self.count += 1
        if len(self.first) < SHOWN_EXAMPLES:
            self.first.append(one)

    def __str__(self) -> str:
        """List the first few."""
        return ", ".join(self.first) + (", ..." if self.count > len(self.first) else "")


class ScriptPlanner:
    """Makes planned lines of rows; the faults of the cast are those of the rows too."""

    def __init__(
        self,
        project: "Project",
        folder: Path,
        *,
        languages: dict[int, ScriptLanguage],
        cast: Cast,
        outputs: Sequence[OutputPattern],
    ) -> None:
        self._languages, self._cast, self._faults = languages, cast, cast.faults
        self._folder, self._recordings = folder, Recordings(folder)
        words = {index: language.word for index, language in languages.items()}
        self._outputs = {
            (index, character): [(o.writer, filled(o.path, word, character)) for o in outputs]
            for index, word in words.items()
            for character in cast.characters
        }
        self._project, self._heard = project, 0
        stated = project.audio, project.timings
        self._audio, self._timings = (
            {index: posixpath.normpath(filled(pattern, word)) for index, word in words.items()}
            if pattern
            else {}
            for pattern in stated
        )
        self._speakers_name_files = any(
            "{speaker}" in path for path in (*stated, *(o.path for o in outputs)) if path
        )
        self._met: dict[int, dict[str, str]] = defaultdict(dict)
        """Places of folded ids by language, or for all languages by `ALL`."""
        self._spelled: dict[str, str] = {}
        """Ids that differ from their folded form."""
        self._speakers: dict[str, str] = {}
        """Faults of speakers as names of files; empty for sound ones."""
        self._lacking: dict[str, dict[int, Examples]] = defaultdict(lambda: defaultdict(Examples))

    def lines(self, file: ScriptFile, row: ScriptRow) -> Iterator[PlannedLine]:
        """Yield the lines of a row; none for one with a fault."""
        place = f"{file.shown}:{row.number}"
        if not self._sound_names(file, row, place):
            return
        characters = self._cast.of(row.speaker, place)
        for index, text in row.texts:
            audio, timings = self._files(index, row, text)
            if not (text or audio or timings):
                self._lacking["text"][index].add(place)
                continue
            for character in characters:
                outputs = [
                    (writer, for_line(pattern, row.name, row.speaker))
                    for writer, pattern in self._outputs[index, character]
                ]
                yield PlannedLine(
                    name=row.name,
                    language=self._languages[index].name,
                    character=character,
                    text=text,
                    speaker=row.speaker,
                    place=place,
                    timings=timings,
                    audio=audio,
                    outputs=tuple(outputs),
                )

    def _sound_names(self, file: ScriptFile, row: ScriptRow, place: str) -> bool:
        """Check that the id is sound and new, and the speaker if it names files."""
        if wrong := fault_of_name(row.name):
            self._faults.add(place, f"the id '{row.name}' {wrong}")
            return False
        if self._speakers_name_files and row.speaker:
            if row.speaker not in self._speakers:
                self._speakers[row.speaker] = wrong = fault_of_name(row.speaker)
                if wrong:
                    what = f"the speaker '{row.speaker}' {wrong}, or leave out {{speaker}}"
                    self._faults.add(place, what)
            if self._speakers[row.speaker]:
                return False
        name, key = row.name, folded_name(row.name)
        whole = len(file.languages) == len(self._languages)
        group = ALL if whole else next(iter(file.languages))
        for other, met in self._met.items():
            if key in met and (whole or other in (ALL, group)):
                spelled = self._spelled.get(key, key)
                if spelled == name:
                    what = f"the id '{name}' is used at {met[key]} already; each line needs its own"
                else:
                    what = (
                        f"the id '{name}' differs from '{spelled}' of {met[key]} only in the form "
                        "of its letters, so macOS and Windows use one file for both; rename one"
                    )
                self._faults.add(place, what)
                return False
        self._met[group][key] = place
        if key != name:
            self._spelled[key] = name
        return True

    def _files(self, index: int, row: ScriptRow, text: str) -> tuple[str | None, str | None]:
        """Return the recording and the timings of a line, if they exist."""
        audio, timings = None, row.timings
        if index in self._timings:
            path = for_line(self._timings[index], row.name, row.speaker)
            timings = timings or self._recordings.find(path)
            if timings is None and text:
                self._lacking["timings"][index].add(path)
        if index in self._audio:
            path = for_line(self._audio[index], row.name, row.speaker)
            audio = self._recordings.find(path)
            self._heard += audio is not None
            if timings is None and index not in self._timings:
                timings = self._recordings.timings_beside(
                    path, lambda: self._own_outputs(index, row)
                )
            if audio is None and timings is None and text:
                self._lacking["recording"][index].add(path)
        elif self._project.recordings == "required" and timings is None:
            self._lacking["recording"][index].add(row.name)
        return audio, timings

    def _own_outputs(self, index: int, row: ScriptRow) -> tuple[str, ...]:
        """Return the paths of a line's outputs, which are not timings of it."""
        return tuple(
            for_line(pattern, row.name, row.speaker)
            for character in self._cast.characters
            for _, pattern in self._outputs[index, character]
        )

    # After all rows

    def check_recordings(self) -> None:
        """Refuse lines without a recording if the project requires them; warn if none has one."""
        lacking = self._lacking["recording"]
        if self._project.recordings == "required":
            for index in lacking:
                what = self._told("recording", index, "without a recording or timings")
                self._faults.state(
                    ("recordings",), "P407", what, "record them, or correct the path"
                )
        elif self._audio and lacking and not self._heard and self._has_recordings():
            lines = sum(found.count for found in lacking.values())
            what = f"no file matches '{self._project.audio}', so voices speak {lines:,} lines"
            hint = "correct the path, or remove it; `recordings: required` makes this a fault"
            self._faults.state(("audio",), "W315", what, hint)
            # The warning replaces the counts by language, which would repeat it.
            lacking.clear()

    def _has_recordings(self) -> bool:
        """Return True if the project has files like its recordings, apart from its outputs."""
        suffix = os.path.splitext(self._project.audio or "")[1].lower()  # noqa: PTH122 text
        made = {path.partition("/")[0] for own in self._outputs.values() for _, path in own}
        for _, below, names in os.walk(self._folder):
            below[:] = [name for name in below if not name.startswith(".") and name not in made]
            if any(name.lower().endswith(suffix) for name in names):
                return True
        return False

    def _told(self, what: str, index: int, told: str) -> str:
        """Return the number of a language's lines that lack something, with examples."""
        found = self._lacking[what][index]
        return f"{self._languages[index].word}: {count(found.count, 'line')} {told}: {found}"

    def check_clashes(self, planned: Sequence[PlannedLine], scripts: Iterable[Path]) -> None:
        """Refuse lines that write to one file, or to a file that is read.

        Only digests are kept of all paths: a million lines have a million of them.
        """
        met: set[int] = set()
        again: set[int] = set()
        for line in planned:
            for _, path in line.outputs:
                # Equal hashes of different paths cost only a second look, at the paths themselves.
                digest = hash(folded_name(path))
                (again if digest in met else met).add(digest)
        read = {folded_name(path) for path in self._recordings.used()}
        read |= {folded_name(os.path.relpath(path, self._folder)) for path in scripts}
        again |= met & {hash(path) for path in read}
        first: dict[str, str] = {}
        for line in planned if again else ():
            for _, path in line.outputs:
                key = folded_name(path)
                if key in read:
                    self._faults.add(line.place, f"the output {path} is an input file")
                elif hash(key) in again and key in first:
                    what = f"the output {path} is also one of {first[key]}"
                    self._faults.add(line.place, f"{what}; put a '/' between its placeholders")
                first.setdefault(key, line.place)

    def tell(self, remark: PlanRemark) -> None:
        """Remark on the number of lines that are left out or lack a recording."""
        for what, told in LACKING.items():
            for index in self._lacking[what]:
                remark(self._told(what, index, told))
        unmet = self._cast.unmet()
        if unmet:
            remark(f"{FILE}: cast: no line is spoken by {shortlist(unmet, SHOWN_EXAMPLES)}")
        unused = Examples()
        for suffix in {os.path.splitext(pattern)[1] for pattern in self._audio.values()}:  # noqa: PTH122
            for path in self._recordings.unused(suffix):
                unused.add(path)
        if unused.count:
            remark(f"{count(unused.count, 'recording')} without a line: {unused}")


class Listing(NamedTuple):
    """The files of a folder: by folded name, and those that may be timings by folded stem."""

    names: dict[str, str]
    timings: dict[str, list[str]]
    used: set[str]
    links: frozenset[str]
    place: str
    """The folder itself."""

    def file(self, name: str, project: Path) -> str:
        """Return a file's path, and count it as used; a link out of the project is refused."""
        found = f"{self.place}{os.sep}{name}"  # a million path objects would fill the memory
        if name in self.links:
            refuse_outside(Path(found), project)
        self.used.add(name)
        return found


class Recordings:
    """Files beside the lines of a script, below a project's folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._listings: dict[str, Listing] = {}

    def find(self, path: str) -> str | None:
        """Return the file of a path from the folder; other case or normal form counts as well."""
        at, _, name = path.rpartition("/")
        listing = self._listing(at)
        found = listing.names.get(folded_name(name)) if listing.names else None
        return None if found is None else listing.file(found, self._folder)

    def timings_beside(self, path: str, taken: Callable[[], Collection[str]]) -> str | None:
        """Return the file of timings that has the stem of a recording, but none of `taken`.

        Suffixes that only timings have come first. A file that cannot be read counts as timings,
        so that its reader says why.
        """
        at, _, name = path.rpartition("/")
        listing = self._listing(at)
        if not listing.timings:
            return None
        for candidate in listing.timings.get(folded_name(name.rpartition(".")[0] or name), ()):
            if f"{at}/{candidate}".lstrip("/") in taken():
                continue
            rare = candidate.lower().endswith(RARE_SUFFIXES)
            if candidate in listing.links:
                refuse_outside(Path(listing.place, candidate), self._folder)
            # Remarks are ignored, because the reading of the timings repeats them.
            beside = LineFile(Path(listing.place, candidate), lambda _: None)
            if rare or is_timed(beside, unreadable=True):
                return listing.file(candidate, self._folder)
        return None

    def used(self) -> Iterator[str]:
        """Yield the files that were returned, as paths from the folder."""
        for at, listing in self._listings.items():
            for name in listing.used:
                yield f"{at}/{name}".lstrip("/")

    def unused(self, suffix: str) -> Iterator[str]:
        """Yield the files with a suffix that `find` never returned, as paths from the folder."""
        for at, listing in sorted(self._listings.items()):
            for name in sorted(set(listing.names.values()) - listing.used):
                if name.lower().endswith(suffix.lower()):
                    yield f"{at}/{name}".lstrip("/")

    def _listing(self, at: str) -> Listing:
        if at not in self._listings:
            refuse_outside(self._folder / at, self._folder)
            try:
                with os.scandir(self._folder / at) as entries:
                    links = {entry.name: entry.is_symlink() for entry in entries}
            except OSError as error:
                if error.errno not in NO_FOLDER:
                    what = f"cannot be read: {error.strerror}; correct its permissions, or the path"
                    raise LipsyncError(f"{at or '.'}: {what}") from None
                links = {}
            names = sorted(links)
            timings: dict[str, list[str]] = {}
            for name in names:
                stem, suffix = os.path.splitext(name)  # noqa: PTH122
                if suffix.lower() in TIMING_SUFFIXES:
                    timings.setdefault(folded_name(stem), []).append(name)
            for some in timings.values():
                some.sort(key=lambda name: (not name.lower().endswith(RARE_SUFFIXES), name))
            known = {folded_name(name): name for name in reversed(names)}
            linked = frozenset(name for name in names if links[name])
            self._listings[at] = Listing(known, timings, set(), linked, str(self._folder / at))
        return self._listings[at]


def read_script(
    pack: "Pack[Project]", *, paths: Paths = (), remark: PlanRemark | None = None
) -> list[PlannedLine]:
    """Read the lines that a project states, in every language and on every character.

    Raises PlanningError if the script or the project is faulty; the message lists the first faults
    with their places.

    Parameters
    ----------
    pack : the project; its `lines` and `outputs` are needed, and its paths start at its folder
    paths : folders of packs to search before those of the project
    remark : where to say what is left out or missing, in counts

    Returns
    -------
    The lines in the order of the script; each has its own outputs.

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
    files = _files(project, folder, languages, finder=finder, faults=faults, remark=tell)
    planned = [
        line
        for file, row in read_apart(files, project.columns, faults, tell)
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


def _check_settings(project: "Project", faults: ScriptFaults) -> None:
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


def _files(  # noqa: PLR0913 the parts of a script
    project: "Project",
    folder: Path,
    languages: dict[int, ScriptLanguage],
    *,
    finder: Finder,
    faults: ScriptFaults,
    remark: PlanRemark,
) -> list[ScriptFile]:
    """List the files of the script; those of one language are read once for each."""
    found: list[ScriptFile] = []
    cleaning = Cleaning(project.values, project.unspoken)
    for stated in project.lines:
        own = [{index: language} for index, language in languages.items()]
        for held in own if "{language}" in stated.replace("{{", "") else [languages]:
            word = next(iter(held.values())).word
            path = Path(shown(folder / fill(stated, {"{language}": word, **BRACES})))
            try:
                listed = dict(line_files(path, remark, project=folder))
            except LipsyncError as error:
                faults.add_error(error)
                continue
            spoken = spoken_in(listed, path, {o.name: o.answers for o in held.values()}, finder)
            for file, among_others in listed.items():
                if its := {index: one for index, one in held.items() if one.name in spoken[file]}:
                    found.append(ScriptFile(file, its, project.encoding, among_others, cleaning))
            if left := [str(file) for file in listed if not spoken[file]]:
                many = count(len(left), "file")
                remark(f"{many} in other languages left out: {shortlist(left, SHOWN_EXAMPLES)}")
    return found
