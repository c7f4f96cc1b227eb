"""Making of a study: renders clips of lines by methods on characters, with a key and a page."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import BinaryIO

from lipsync_lang import Animation, LipsyncError
from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.files import write_all
from lipsync_lang.base.files.writing import cannot_write
from lipsync_lang.plugins.study.methods import Method, StudyCharacter, lacks, spoilt
from lipsync_lang.plugins.study.study_clips import Clip, render_clips
from lipsync_lang.plugins.study.study_file import (
    QUESTIONS,
    STUDY_NAME,
    Study,
    StudyPair,
    as_text,
    read_study,
    refuse_links,
    study_digest,
)
from lipsync_lang.plugins.study.study_lines import (
    MAX_LISTED_LINES,
    ClipPair,
    StudyLine,
    in_balanced_order,
    laid_out,
    possible_pairs,
    timed,
)
from lipsync_lang.plugins.study.study_page import PageTexts, study_page

PAIRS_PER_CHECK = 10
"""Number of pairs per attention check, unless the number of checks is given."""

PAGE, CLIPS = "page.html", "clips"
"""Names in the folder of a study, beside `STUDY_NAME`: page for raters, and rendered clips."""

StepProgress = Callable[[str, int, int], None]
"""Progress: kind of work, number done, and total."""


@dataclass(frozen=True)
class StudyPlan:
    """Contents of a study to make: lines, characters, methods and texts."""

    lines: tuple[StudyLine, ...]
    characters: tuple[StudyCharacter, ...]
    methods: tuple[Method, ...]
    title: str = "Which face speaks better?"
    texts: PageTexts = field(default_factory=PageTexts)
    questions: tuple[str, ...] = QUESTIONS
    most: int | None = None
    """Maximum number of pairs; None for all."""
    checks: int | None = None
    """Number of attention checks; None for one in ten pairs."""
    raters_see: int | None = None
    """Number of pairs that each rater sees; None for all."""
    seed: int = 1
    engine: str | None = None
    """Speech engine of lines without a recording; None for the language's."""


@dataclass(frozen=True)
class NewStudy:
    """A study in its folder."""

    study: Study
    folder: Path
    rendered: int
    """Number of clips rendered in this run."""
    page_bytes: int
    remarks: tuple[str, ...] = ()
    """Sentences on pairs that were left out, with the reason."""


def make_study(
    plan: StudyPlan,
    folder: Path,
    *,
    workers: int | None = None,
    told: StepProgress = lambda *_: None,
) -> NewStudy:
    """Render the clips of a study, and write its key and its page.

    After an interruption, a new run renders only the remaining clips. Raises LipsyncError if there
    is no pair to show, the folder holds another study, or a clip cannot be made.
    """
    plan.texts.refuse_faults()
    stage = _PairMaker(plan, told)
    chosen = stage.chosen()
    checks = max(1, round(len(chosen) / PAIRS_PER_CHECK)) if plan.checks is None else plan.checks
    pairs = laid_out(chosen, checks, plan.seed)
    clips = dict(stage.clips(pairs))
    lengths = {name: round(max(clip.seconds for clip in two), 2) for name, two in clips.items()}
    # Raters who answer faster than the longer clip plays cannot have seen both.
    pairs = tuple(pair.model_copy(update={"seconds": lengths[pair.pair]}) for pair in pairs)
    study = _study(plan, pairs, {name: [c.digest for c in two] for name, two in clips.items()})
    # After the digest is known, and before minutes of rendering.
    _refuse_another(folder, study)
    made = [clip for two in clips.values() for clip in two]
    rendered = render_clips(made, folder / CLIPS, workers=workers, told=partial(told, "clip"))

    def content(name: str) -> list[bytes]:
        return [clip.path(folder / CLIPS).read_bytes() for clip in clips[name]]

    def page(stream: BinaryIO) -> None:
        stream.writelines(part.encode() for part in study_page(study, plan.texts, content))

    def key(stream: BinaryIO) -> None:
        stream.write(as_text(study).encode())

    write_all({folder / STUDY_NAME: key, folder / PAGE: page})
    size = (folder / PAGE).stat().st_size
    return NewStudy(study, folder, rendered, size, tuple(stage.remarks))


class _PairMaker:
    """Animations of a plan's lines, each made once."""

    def __init__(self, plan: StudyPlan, told: StepProgress) -> None:
        self.remarks: list[str] = []
        self._plan, self._told = plan, told
        self._characters = {cast.name: cast for cast in plan.characters}
        self._lines = {line.name: line for line in plan.lines}
        self._methods = {method.name: method for method in plan.methods}
        self._own: dict[tuple[str, str], Animation] = {}
        self._made: dict[tuple[str, str, str], Animation | LipsyncError] = {}

    def chosen(self) -> list[ClipPair]:
        """Return the pairs to show; pairs that cannot be made are left out with a remark."""
        plan = self._plan
        pairs: list[ClipPair] = []
        for method in plan.methods:
            without = [line.name for line in plan.lines if lacks(method, line.name)]
            if without:
                some = shortlist(without, MAX_LISTED_LINES)
                remark = f"method '{method.name}' has no file for {some}; these lines are left out"
                self.remarks.append(remark)
        found = possible_pairs(
            list(self._lines), list(self._characters), list(self._methods),
            lambda method, line: lacks(self._methods[method], line),
        )  # fmt: skip
        for pair in in_balanced_order(found, plan.seed):
            if plan.most is not None and len(pairs) >= plan.most:
                break
            made = (self._animation(pair.line, pair.character, one) for one in pair.methods)
            fault = next((one for one in made if isinstance(one, LipsyncError)), None)
            if fault is None:
                pairs.append(pair)
                self._told("line", len(pairs), plan.most or len(pairs))
                continue
            remark = f"{pair.line} on {pair.character}: {fault}; left out"
            if remark not in self.remarks:
                self.remarks.append(remark)
        if not pairs:
            raise LipsyncError("\n".join(("no pair can be shown", *self.remarks)))
        return pairs

    def _animation(self, line: str, character: str, method: str) -> Animation | LipsyncError:
        key = (line, character, method)
        if key not in self._made:
            cast = self._characters[character]
            try:
                if (line, character) not in self._own:
                    schedule = timed(self._lines[line], cast.performer, engine=self._plan.engine)
                    self._own[line, character] = cast.frames(schedule)
                own = self._own[line, character]
                self._made[key] = cast.animate(self._methods[method], line, own)
            except LipsyncError as error:
                self._made[key] = error
        return self._made[key]

    def clips(self, pairs: Sequence[StudyPair]) -> Iterator[tuple[str, tuple[Clip, Clip]]]:
        """Yield the name and the clips of each pair, left and right."""
        number = 0
        for pair in pairs:
            own = self._own[pair.line, pair.character]
            sides = {}
            for side, method in (("left", pair.left), ("right", pair.right)):
                made = self._animation(pair.line, pair.character, method)
                assert not isinstance(made, LipsyncError)  # noqa: S101 such a pair is not chosen
                if pair.check is not None and side != pair.check:
                    made = spoilt(made, number)
                    number += 1
                sides[side] = Clip(made, own)
            yield pair.pair, (sides["left"], sides["right"])


def _study(plan: StudyPlan, pairs: tuple[StudyPair, ...], clips: dict[str, list[str]]) -> Study:
    """Return a study with the digest of its page, its clips and its key."""
    contents = {
        "kind": "study",
        "format": 1,
        "title": plan.title,
        "seed": plan.seed,
        "questions": plan.questions,
        "methods": tuple(method.name for method in plan.methods),
        "raters_see": plan.raters_see,
        "pairs": pairs,
        "asked": tuple(one.key for one in plan.texts.asked),
    }
    plain = contents | {
        "pairs": [pair.model_dump() for pair in pairs],
        "clips": clips,
        "consent": plan.texts.consent,
        "choices": [(one.label, one.choices) for one in plan.texts.asked],
    }
    return Study.model_validate(contents | {"study": study_digest(plain)})


def _refuse_another(folder: Path, study: Study) -> None:
    """Refuse a folder with another study, a folder that cannot be made, and links out of it."""
    refuse_links(folder)
    key = folder / STUDY_NAME
    if key.exists():
        there = read_study(key)
        if there.study != study.study:
            what = f"contains another study, '{there.title}' ({there.study})"
            raise LipsyncError(f"{folder}: {what}; name another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from None
