"""Files of a study: `study.json` with the key to the sides, and the answers of raters.

The study file stays with the authors of the study. Raters see a page without the key, and their
answers name only pairs and sides. Answers are a JSON file of one rater, or JSON lines with one
submission each.
"""

import json
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, StringConstraints, ValidationError

from lipsync_lang import LipsyncError
from lipsync_lang.base.files import read_input
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.packs.models.fields import Strict

STUDY_NAME = "study.json"
"""Name of the file with the key, which stays with the authors of a study."""

MAX_STUDY_BYTES = 16 * 2**20
MAX_ANSWERS_BYTES = 256 * 2**20
MAX_PAIRS = 2_000

MAX_SUBMISSION_BYTES = 2**20
"""Size limit in bytes of one rater's answers: `MAX_PAIRS` pairs, two questions each."""

STUDY_DIGEST_BYTES = 8
"""Length of a study's digest and of a rater's number in bytes."""

QUESTIONS = ("accuracy", "naturalness")
"""The questions of the paper's study (section 4.1)."""

ClipSide = Literal["left", "right"]
Question = Literal["accuracy", "naturalness"]
Hex = Annotated[str, StringConstraints(pattern="^[0-9a-f]{16}$")]
ShortText = Annotated[str, StringConstraints(min_length=1, max_length=100)]
FreeText = Annotated[str, StringConstraints(max_length=500)]
Moment = Annotated[
    str, StringConstraints(pattern=r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)$")
]

M = TypeVar("M", bound=Strict)

REPORT_FORMAT = "lipsync-lang study report 1"
"""Format of reports, which may be in the same folder as answers."""

REPORT_HEAD_BYTES = 80
"""Number of bytes at the start of a report that contain its format."""


class StudyPair(Strict):
    """Two clips of one line and character, shown side by side."""

    pair: ShortText
    """Name of the pair, such as `p001`."""
    line: ShortText
    """Name of the line."""
    character: ShortText
    """Name of the character."""
    left: ShortText
    """Method of the left clip."""
    right: ShortText
    """Method of the right clip."""
    check: ClipSide | None = None
    """Correct side of an attention check; the other side is deliberately wrong."""
    seconds: Annotated[float, Field(gt=0, le=3600)] | None = None
    """Length of the longer clip; null if unknown."""


class Study(Strict):
    """A study with its key: the methods behind the sides of each pair."""

    kind: Literal["study"]
    """`study`."""
    format: Literal[1]
    """Version of the form."""
    study: Hex
    """Digest of the study and its clips; answers contain it."""
    title: FreeText
    """Title that raters see."""
    seed: int
    """Seed of the choice of pairs and sides."""
    questions: Annotated[tuple[Question, ...], Field(min_length=1)]
    """Questions of each pair."""
    methods: Annotated[tuple[ShortText, ...], Field(min_length=2)]
    """Names of the compared methods."""
    raters_see: Annotated[int, Field(ge=1)] | None = None
    """Number of pairs that each rater sees; null for all."""
    pairs: Annotated[tuple[StudyPair, ...], Field(min_length=1, max_length=MAX_PAIRS)]
    """All pairs."""
    asked: tuple[ShortText, ...] = ()
    """Keys of the questions about the rater."""


class PairAnswer(Strict):
    """A rater's choice on one question of one pair."""

    pair: ShortText
    """Name of the pair."""
    question: Question
    """The question."""
    choice: ClipSide
    """The better side."""
    strength: Annotated[int, Field(ge=1, le=5)]
    """Strength of the preference, from 1 (weak) to 5 (strong)."""
    seconds: Annotated[float, Field(ge=0, le=1e6)]
    """Time from the first view of the pair to the choice, in seconds."""
    plays: Annotated[int, Field(ge=0, le=100_000)]
    """Times that the clips of the pair were played."""


class Submission(Strict):
    """The answers of one rater."""

    kind: Literal["answers"]
    """`answers`."""
    format: Literal[1]
    """Version of the form."""
    study: Hex
    """Digest of the study."""
    rater: Hex
    """Random number of the rater, made in the browser."""
    consent: Literal[True]
    """True in all answers: raters consent first."""
    started: Moment
    """Time of consent, ISO 8601."""
    finished: Moment | None
    """Time of the last answer, ISO 8601; null if the rater stopped early."""
    asked: Annotated[dict[ShortText, FreeText], Field(max_length=50)]
    """Answers to the questions about the rater, by key."""
    answers: Annotated[tuple[PairAnswer, ...], Field(max_length=2 * MAX_PAIRS)]
    """Choices in the order of time."""


def refuse_links(folder: Path) -> None:
    """Raise an error if a folder that a user typed, or a file in it, is a link out of it.

    A folder that is typed from the current one may be a link that came with a project.
    """
    here = Path.cwd()
    if Path(os.path.abspath(folder)).is_relative_to(here):  # noqa: PTH100 as it is written
        refuse_outside(folder, here)
    for path in folder.rglob("*"):
        if path.is_symlink():
            refuse_outside(path, folder)


def read_study(path: Path) -> Study:
    """Read a study file; a LipsyncError names the place if it is not a study."""
    content = read_input(path, MAX_STUDY_BYTES, mend="name the study.json of a study")
    study = parsed(Study, content, str(path))
    for field, names in (("methods", study.methods), ("questions", study.questions)):
        twice = next((name for at, name in enumerate(names) if name in names[:at]), None)
        if twice is not None:
            raise LipsyncError(f"{path}: {field}: has '{twice}' twice; make the study again")
    seen: set[str] = set()
    for number, pair in enumerate(study.pairs):
        unknown = next((m for m in (pair.left, pair.right) if m not in study.methods), None)
        fault = ""
        if unknown is not None:
            fault = f"unknown method '{unknown}'"
        elif pair.left == pair.right and pair.check is None:
            fault = f"'{pair.left}' is on both sides, but is not an attention check"
        elif pair.pair in seen:
            fault = f"two pairs have the name '{pair.pair}'"
        if fault:
            raise LipsyncError(f"{path}: pairs.{number}: {fault}; make the study again")
        seen.add(pair.pair)
    return study


def study_digest(contents: object) -> str:
    """Return the digest of a study's contents, given as JSON data."""
    # Sorted, so that equal contents have one digest.
    text = json.dumps(contents, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return blake2b(text.encode(), digest_size=STUDY_DIGEST_BYTES).hexdigest()


def as_text(model: Study | Submission) -> str:
    """Return the JSON text of a study, indented, or of a submission, in one line."""
    indent = 1 if isinstance(model, Study) else None
    return f"{model.model_dump_json(indent=indent)}\n"


def parsed(model: type[M], content: bytes, where: str) -> M:
    """Parse a model from a JSON text; a LipsyncError has the first fault."""
    try:
        return model.model_validate_json(content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(map(str, first["loc"]))
        kind = "study" if model is Study else "answers"
        raise LipsyncError(
            f"{where}: {f'{place}: ' if place else ''}{first['msg']}; "
            f"give a file of kind '{kind}' in format 1"
        ) from None
    except RecursionError:
        raise LipsyncError(f"{where}: is nested too deeply; give a file of answers") from None


def faults_against(submission: Submission, study: Study) -> tuple[str, ...]:
    """List contradictions between a submission and a study as sentences; empty if none."""
    if submission.study != study.study:
        return (f"the answers are for study {submission.study}, not {study.study}",)
    pairs = {pair.pair for pair in study.pairs}
    faults, seen = [], set()
    for number, one in enumerate(submission.answers):
        key = (one.pair, one.question)
        if one.pair not in pairs:
            faults.append(f"answers.{number}: the study has no pair '{one.pair}'")
        elif one.question not in study.questions:
            faults.append(f"answers.{number}: the study does not ask about {one.question}")
        elif key in seen:
            faults.append(f"answers.{number}: {one.pair} has two answers about {one.question}")
        seen.add(key)
    unknown = sorted(submission.asked.keys() - set(study.asked))
    faults += [f"asked.{key}: the study does not ask this question" for key in unknown]
    return tuple(faults)


def answer_files(places: Iterable[Path]) -> list[Path]:
    """Return the files of answers in files and folders, in order, each once.

    Folders give their `.json` and `.jsonl` files, without the study itself and reports of it.
    Raises LipsyncError if a folder cannot be read, or contains no such file.
    """
    found: dict[Path, None] = {}
    for place in places:
        if not place.is_dir():
            found[place] = None
            continue
        inside = []
        for path in sorted(place.iterdir()):
            if path.suffix in {".json", ".jsonl"} and path.name != STUDY_NAME and path.is_file():
                start = b""
                with suppress(OSError), path.open("rb") as stream:
                    start = stream.read(REPORT_HEAD_BYTES)
                if not (start.startswith(b"{") and f'"{REPORT_FORMAT}"'.encode() in start):
                    inside.append(path)
        if not inside:
            what = "contains no .json or .jsonl file of answers; name another folder"
            raise LipsyncError(f"{place}: {what}")
        found |= dict.fromkeys(inside)
    return list(found)


def texts_of(paths: Iterable[Path]) -> Iterator[tuple[str, bytes | LipsyncError]]:
    """Yield the place and text of each submission, or the error of an unreadable file."""
    for path in paths:
        try:
            content = read_input(path, MAX_ANSWERS_BYTES, mend="split the file")
        except LipsyncError as error:
            yield str(path), error
            continue
        # Blank lines at the ends would make one document look like JSON lines.
        content = content.strip()
        lines = content.split(b"\n")
        documents = (parse_document(line)[2] for line in lines)
        # JSON lines have a whole document in some line; an indented document has none.
        if len(lines) == 1 or not any(isinstance(one, dict) and "kind" in one for one in documents):
            yield str(path), content
            continue
        for number, line in enumerate(lines, 1):
            if line.strip():
                yield f"{path}:{number}", line


def parse_document(text: bytes | LipsyncError) -> tuple[str, str, Any]:
    """Return the document after a reason and its words, which are empty if the text is JSON."""
    if isinstance(text, LipsyncError):
        return "unreadable", str(text), None
    if len(text) > MAX_SUBMISSION_BYTES:
        return "unreadable", "is larger than the answers of a rater can be", None
    try:
        return "", "", json.loads(text)
    except (ValueError, RecursionError) as error:
        words = "is empty" if not text else f"is not JSON or is cut off: {error}"
        return "unreadable", words, None
