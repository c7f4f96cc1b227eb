"""Commented YAML text of a pose set, short enough for one screen if possible.

Lengths are in lines and in characters per line.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from textwrap import wrap

from lipsync_lang.authoring.new_pack import head
from lipsync_lang.packs.models import ContactRule, Phonemes, PhonemeTarget, PoseSet
from lipsync_lang.packs.models.pose_models import NO_THRESHOLD

MAX_SCREEN_LINES = 90
"""Maximum number of lines before a denser layout is used."""

WRAP_CHARS = 100
"""Maximum line width in characters for wrapped lists."""

_PLAIN_NAME = re.compile(r"[^\W\d][\w.]*(-[\w.]+)*")
_SPACED = re.compile(r"[^\W\d]\w*( [\w()/'-]+)+")
_YAML_LITERALS = {"true", "false", "null"}


def laid_out(
    model: PoseSet, common: Phonemes, why: Mapping[str, str], left: Sequence[str] = ()
) -> str:
    """Format a pose set as YAML in the most spacious layout within the line limit.

    Parameters
    ----------
    common : common phonemes, for the titles of sounds
    why : comments by pose; the key "" holds the general comment
    left : unused names, listed in a comment
    """
    lines: list[str] = []
    for packed, dense in ((False, False), (True, False), (True, True)):
        lines = [*_lines(model, common, why, left, packed=packed)]
        lines = [line for line in lines if line or not dense]
        if len(lines) <= MAX_SCREEN_LINES:
            break
    return "\n".join(lines) + "\n"


def scalar(text: str, plain: re.Pattern[str] = _PLAIN_NAME) -> str:
    """Format a string as a YAML scalar, quoted if it does not match the pattern of plain text."""
    if plain.fullmatch(text) and text.casefold() not in _YAML_LITERALS:
        return text
    return json.dumps(text, ensure_ascii=False)


def _lines(
    model: PoseSet,
    common: Phonemes,
    why: Mapping[str, str],
    left: Sequence[str],
    *,
    packed: bool,
) -> Iterator[str]:
    name = model.name
    yield f"# {model.title}: a draft. It runs as it is:"
    yield f'#   lipsync-lang run "Hello" -l LANGUAGE -c {name} --plot {name}.png'
    yield from (f"# {line}" for line in wrap(why[""], WRAP_CHARS - 2))
    yield from head("poseset", name)
    yield f"title: {_flow(model.title)}"
    if model.model is not None:
        yield f"model: {scalar(model.model)}"
    yield ""
    yield from _poses(model, why, packed=packed)
    if left:
        yield "# Unused shapes. To use a shape, add it to `poses` and to `targets`:"
        yield from _wrapped("#   ", map(scalar, left), "")
    yield ""
    yield from _constraints(model, packed=packed)
    yield ""
    yield "# Contacts, visible at any speed: poses that rise to a floor, or stay below a ceiling"
    yield from _contacts(model.contacts)
    yield ""
    yield "# Settings of the motion; speed_limit is the highest weight per second of a pose"
    yield f"motion: {_flow(model.motion.model_dump(exclude_none=True))}"
    yield ""
    yield "# Weight of each pose at each sound, from 0 to 1. A pose that is not named is at rest."
    yield "targets:"
    yield from _targets(model, common, packed=packed)
    if model.measures:
        yield ""
        yield "# Measures for quality reports: sums of gain times pose"
        yield "measures:"
        yield from (f"  {scalar(k)}: {_flow(gains)}" for k, gains in model.measures.items())


def _targets(model: PoseSet, common: Phonemes, *, packed: bool) -> Iterator[str]:
    entries = {label: f"  {label + ':':<4} {_steps(s)}" for label, s in model.targets.items()}
    width = min(40, max(map(len, entries.values()), default=0))
    for label, entry in entries.items():
        told = common.phonemes[label].title if label in common.phonemes and not packed else ""
        yield f"{entry:<{width}}   # {told}" if told else entry


def _poses(model: PoseSet, why: Mapping[str, str], *, packed: bool) -> Iterator[str]:
    if packed:
        told = (f"{scalar(n)}: {_flow(_stated(region=p.region))}" for n, p in model.poses.items())
        yield from _wrapped("poses: {", told, "}")
        return
    yield "poses:"
    width = max(len(scalar(name)) for name in model.poses) + 1
    for name, pose in model.poses.items():
        stated = _flow(_stated(title=pose.title, region=pose.region))
        entry = f"  {scalar(name) + ':':<{width}} {stated}"
        yield f"{entry}   # {why[name]}" if name in why else entry


def _constraints(model: PoseSet, *, packed: bool) -> Iterator[str]:
    """Format the constraints; without any, a commented-out example."""
    stated = model.constraints
    pairs = [_flow(pair.model_dump(exclude_none=True)) for pair in stated.pairs]
    binds = stated.default < NO_THRESHOLD
    yield "# Pairs of poses with the highest sum of their weights; `priority` has the weakest first"
    if not pairs and not binds:
        some = [*model.poses, *model.poses][:2]
        yield f"# constraints: {{pairs: [{{between: {_list(some)}, threshold: 1}}]}}"
        yield f"# priority: {_list(some[:1])}"
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
        yield from _wrapped("priority: [", map(scalar, model.priority), "]")


def _contacts(contacts: Mapping[str, ContactRule]) -> Iterator[str]:
    yield "contacts:" if contacts else "contacts: {}"
    for name, contact in contacts.items():
        parts = {"floor": contact.floor, "ceiling": contact.ceiling}
        held = "".join(f", {part}: {_flow(poses)}" for part, poses in parts.items() if poses)
        yield f"  {scalar(name)}: {{phonemes: {_list(contact.phonemes)}{held}}}"


def _steps(steps: Sequence[PhonemeTarget]) -> str:
    told = []
    for step in steps:
        insisting = step.dominance or step.overall
        dominance = {} if insisting in ({}, None) else {"dominance": insisting}
        told.append(_flow({**step.weights, **dominance}))
    return told[0] if len(told) == 1 else f"[{', '.join(told)}]"


def _stated(**fields: str) -> dict[str, str]:
    return {field: text for field, text in fields.items() if text}


def _list(names: Iterable[str]) -> str:
    return f"[{', '.join(map(scalar, names))}]"


def _flow(value: object) -> str:
    """Format plain data as one line of flow-style YAML."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{scalar(key)}: {_flow(inner)}' for key, inner in value.items())}}}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_flow, value))}]"
    if isinstance(value, str):
        return scalar(value) if not _SPACED.fullmatch(value) else value
    return f"{value:g}" if isinstance(value, float) else json.dumps(value)


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
