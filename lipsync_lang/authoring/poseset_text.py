"""Commented YAML text of a pose set, short enough for one screen if possible.

Lengths are in lines and in characters per line.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from textwrap import wrap

from lipsync_lang.authoring.new_pack import WRAP_CHARS, head
from lipsync_lang.packs.models import Phonemes, PoseSet
from lipsync_lang.packs.models.pose_models import NO_THRESHOLD
from lipsync_lang.packs.yaml.value_text import as_scalar, on_one_line

MAX_SCREEN_LINES = 90
"""Maximum number of lines before a denser layout is used."""


def poseset_lines(
    model: PoseSet, common: Phonemes, why: Mapping[str, str], left: Sequence[str] = ()
) -> list[str]:
    """Format a pose set as YAML in the most spacious layout within the line limit.

    `common` are common phonemes, for the titles of sounds; `why` are comments by pose, with the
    general one under ""; `left` are unused names, listed in a comment.
    """
    lines: list[str] = []
    for packed, dense in ((False, False), (True, False), (True, True)):
        lines = [*_lines(model, common, why, left, packed=packed)]
        lines = [line for line in lines if line or not dense]
        if len(lines) <= MAX_SCREEN_LINES:
            break
    return lines


def _lines(
    model: PoseSet, common: Phonemes, why: Mapping[str, str], left: Sequence[str], *, packed: bool
) -> Iterator[str]:
    name = model.name
    yield f"# {model.title}: a draft. It runs as it is:"
    yield f'#   lipsync-lang run "Hello" -l LANGUAGE -c {name} -o {name}.html'
    yield from (f"# {line}" for line in wrap(why[""], WRAP_CHARS - 2))
    model_file = as_scalar(model.model) if model.model is not None else None
    yield from head("poseset", name, title=on_one_line(model.title), model=model_file)
    yield ""
    yield from _poses(model, why, packed=packed)
    if left:
        yield "# Unused shapes. To use a shape, add it to `poses` and to `targets`:"
        yield from _wrapped("#   ", map(as_scalar, left), "")
    yield ""
    yield from _constraints(model, packed=packed)
    yield ""
    yield "# Contacts, visible at any speed: poses that rise to a floor, or stay below a ceiling"
    yield "contacts:" if model.contacts else "contacts: {}"
    for title, contact in model.contacts.items():
        parts = {"phonemes": contact.phonemes, "floor": contact.floor, "ceiling": contact.ceiling}
        held = {part: poses for part, poses in parts.items() if poses or part == "phonemes"}
        yield f"  {as_scalar(title)}: {on_one_line(held)}"
    yield ""
    yield "# Settings of the motion; speed_limit is the highest weight per second of a pose"
    yield f"motion: {on_one_line(model.motion.model_dump(exclude_none=True))}"
    yield ""
    yield "# Weight of each pose at each sound, from 0 to 1. A pose that is not named is at rest."
    yield "targets:"
    yield from _targets(model, common, packed=packed)
    if model.measures:
        yield ""
        yield "# Measures for quality reports: sums of gain times pose"
        yield "measures:"
        yield from (
            f"  {as_scalar(k)}: {on_one_line(gains)}" for k, gains in model.measures.items()
        )


def _targets(model: PoseSet, common: Phonemes, *, packed: bool) -> Iterator[str]:
    entries = {}
    for label, steps in model.targets.items():
        told = []
        for step in steps:
            insisting = step.dominance or step.overall
            dominance = {} if insisting in ({}, None) else {"dominance": insisting}
            told.append(on_one_line({**step.weights, **dominance}))
        listed = told[0] if len(told) == 1 else f"[{', '.join(told)}]"
        entries[label] = f"  {label + ':':<4} {listed}"
    width = min(40, max(map(len, entries.values()), default=0))
    for label, entry in entries.items():
        title = common.phonemes[label].title if label in common.phonemes and not packed else ""
        yield f"{entry:<{width}}   # {title}" if title else entry


def _poses(model: PoseSet, why: Mapping[str, str], *, packed: bool) -> Iterator[str]:
    if packed:
        told = (f"{as_scalar(n)}: {_pose('', p.region)}" for n, p in model.poses.items())
        yield from _wrapped("poses: {", told, "}")
        return
    yield "poses:"
    width = max(len(as_scalar(name)) for name in model.poses) + 1
    for name, pose in model.poses.items():
        entry = f"  {as_scalar(name) + ':':<{width}} {_pose(pose.title, pose.region)}"
        yield f"{entry}   # {why[name]}" if name in why else entry


def _constraints(model: PoseSet, *, packed: bool) -> Iterator[str]:
    """Format the constraints; without any, a commented-out example."""
    stated = model.constraints
    pairs = [on_one_line(pair.model_dump(exclude_none=True)) for pair in stated.pairs]
    binds = stated.default < NO_THRESHOLD
    yield "# Pairs of poses with the highest sum of their weights; `priority` has the weakest first"
    if not pairs and not binds:
        some = [*model.poses, *model.poses][:2]
        yield f"# constraints: {{pairs: [{{between: {on_one_line(some)}, threshold: 1}}]}}"
        yield f"# priority: {on_one_line(some[:1])}"
        return
    yield "constraints:"
    if binds:
        yield f"  default: {stated.default:g}"
    if pairs and packed:
        yield from _wrapped("  pairs: [", pairs, "]")
    elif pairs:
        yield "  pairs:"
        yield from (f"    - {pair}" for pair in pairs)
    if model.priority:
        yield from _wrapped("priority: [", map(as_scalar, model.priority), "]")


def _pose(title: str, region: str) -> str:
    fields = {"title": title, "region": region}
    return on_one_line({field: text for field, text in fields.items() if text})


def _wrapped(head: str, items: Iterable[str], end: str) -> Iterator[str]:
    """Yield the head and its items, wrapped at the line width and indented below the head."""
    line, indent = head, "#   " if head.startswith("#") else " " * len(head)
    told = list(items)
    for number, item in enumerate(told):
        last = number == len(told) - 1
        more = item + (end if last else ", ")
        if len(line) + len(more) > WRAP_CHARS and line.strip(" #"):
            yield line.rstrip()
            line = indent
        line += more
    yield line
