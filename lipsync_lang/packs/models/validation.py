"""Validate a file against the model of its kind, and turn pydantic's errors into faults.

Messages use the words of the file, never names of Python classes.
"""

import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, cast, get_args, get_origin

from pydantic import BaseModel, ValidationError

from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.packs.models import MODELS, PackModel
from lipsync_lang.packs.models.fields import PACK_FORMAT, descriptions
from lipsync_lang.packs.yaml.building import NO_COLON
from lipsync_lang.packs.yaml.events import load_yaml
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.source import Data, Loc, YamlSource

AnyModel = TypeVar("AnyModel", bound=BaseModel)

PydanticError = Mapping[str, Any]
"""An entry of `ValidationError.errors()`."""

COMMA_CODES = frozenset(("P101", "P103", "P104", "P108", "P114"))
"""Codes of faults that a decimal comma causes: it makes two values of one number."""

KEY_STEP = "[key]"
"""Last step of pydantic's location for an error in a key."""

MAX_QUOTED_CHARS = 40
"""Characters of a value that a message quotes."""

_PATTERN = "write a BCP 47 tag such as 'pt-BR'"


@cache
def _words() -> dict[str, dict[str, Any]]:
    """Return the words for pydantic's errors, from `validation.yaml`."""
    text = Path(__file__).with_suffix(".yaml").read_text("utf-8")
    return cast("dict[str, dict[str, Any]]", load_yaml(text))


def validated(
    source: YamlSource, *, kind: str | None = None, name: str | None = None
) -> tuple[PackModel | None, tuple[Fault, ...]]:
    """Return the pack in a file (None if faulty), and every fault of the file.

    `kind` and `name` are those expected for the file's place; None accepts any.
    """
    model, faults = _kind(source, kind) if source.data is not None else (None, [])
    pack = None
    if model is not None:
        try:
            pack = model.model_validate(source.data)
        except ValidationError as error:
            faults += _translate(source, model, error)
        stated = source.data.get("name")
        if name is not None and isinstance(stated, str) and stated != name:
            what = f"the pack is named '{stated}', but its file or folder is named '{name}'"
            faults.append(source.fault(("name",), "P111", what, "rename one of the two"))
    # a value that an alias repeats is faulty at one place, however often it is repeated
    faults = sorted({*source.faults, *faults})
    return (None if faults else pack), tuple(faults)


def validated_as(
    source: YamlSource, model: type[AnyModel]
) -> tuple[AnyModel | None, tuple[Fault, ...]]:
    """Return the contents of a file that is not a pack (None if faulty), and every fault of it."""
    try:
        return model.model_validate(source.data), ()
    except ValidationError as error:
        return None, tuple(sorted(set(_translate(source, model, error))))


def _kind(source: YamlSource, kind: str | None) -> tuple[type[PackModel] | None, list[Fault]]:
    """Return the model for a file, or None and the fault of its `kind` or `format`."""
    data = source.data
    start = "start it with `kind: ...`, `format: 1` and `name: ...`"
    if not isinstance(data, dict):
        what = f"a pack must be a mapping, got {_got(data)}"
        return None, [source.fault((), "P103", what, start)]
    stated = data.get("kind")
    if stated is None:
        return None, [source.fault(("kind",), "P102", "missing field `kind`", start)]
    if not isinstance(stated, str) or stated not in MODELS:
        hint = did_you_mean(str(stated), MODELS)
        return None, [source.fault(("kind",), "P109", f"unknown kind {_got(stated)}", hint)]
    if kind is not None and stated != kind:
        what = f"a pack of kind '{stated}' in the place of kind '{kind}'"
        hint = "move the file to its folder, or correct its `kind`"
        return None, [source.fault(("kind",), "P109", what, hint)]
    number = data.get("format")
    # True is an int as well
    if type(number) is int and number > PACK_FORMAT:
        what = f"the pack is in format {number}; this program reads format {PACK_FORMAT}"
        hint = "use a newer version of the program"
        return None, [source.fault(("format",), "P110", what, hint)]
    return MODELS[stated], []


def _translate(source: YamlSource, model: type[BaseModel], error: ValidationError) -> list[Fault]:
    """Turn pydantic's errors into faults."""
    faults: list[Fault] = []
    for report in error.errors(include_url=False):
        sort, value, context = report["type"], report["input"], report.get("ctx", {})
        counted = sort == "too_short" and isinstance(value, (tuple, list, dict, str))
        if counted and len(value) >= context["min_length"]:
            continue  # it is too short only because pydantic dropped faulty items
        loc: Loc = tuple(report["loc"])
        key = bool(loc) and loc[-1] == KEY_STEP
        loc = loc[:-1] if key else loc
        loc += tuple(context[step] for step in ("field", "at") if step in context)
        code, what, hint = _say(source, model, loc, report)
        if code in COMMA_CODES and source.where(loc).line in source.decimal_commas:
            hint = "write a decimal point, not a comma: 0.5, not 0,5"
        faults.append(source.fault(loc, code, what, hint, key=key or sort == "extra_forbidden"))
    return faults


MAX_KINDS = 2
"""Maximum number of kinds of files that a hint names for a field of theirs."""


def _say(  # noqa: C901, PLR0911 one return for each family of errors
    source: YamlSource, model: type[BaseModel], loc: Loc, report: PydanticError
) -> tuple[str, str, str]:
    """Return the code, message and hint for one error."""
    sort, value, context = report["type"], report["input"], report.get("ctx", {})
    subject = _subject(source, loc)
    if sort == "extra_forbidden":
        hint = _elsewhere(loc) or did_you_mean(str(loc[-1]), _fields(model, loc))
        return "P101", f"unknown field `{loc[-1]}`", hint
    if sort == "missing" and isinstance(loc[-1], str):
        form = "format: 1" if loc[-1] == "format" else f"{loc[-1]}: ..."
        meaning = _fields(model, loc).get(loc[-1], "")
        return "P102", f"missing field `{loc[-1]}`", f"add `{form}`: {meaning}".rstrip(": ")
    # Pydantic also says "missing" of an item of a tuple, by its number.
    if sort in ("missing", "too_short", "too_long"):
        return _length(source, loc, report)
    if sort in _words()["types"]:
        needed = bool(loc) and loc[-1] in _fields(model, loc, required=True)
        what = f"{subject} must be {_words()['types'][sort]}, got {_got(value)}"
        return "P103", what, _mend(sort, value, needed=needed)
    if sort in _words()["ranges"]:
        bound, word = _words()["ranges"][sort]
        hint = f"write a number that is {word} {context[bound]:g}"
        return "P104", f"{subject} must be {word} {context[bound]:g}, got {value:g}", hint
    if sort == "finite_number":
        return "P105", f"{subject} must be a finite number, got {value}", ""
    if sort in ("string_pattern_mismatch", "string_too_long"):
        hint = _words()["patterns"].get(context.get("pattern", ""), _PATTERN)
        hint = hint if "pattern" in context else f"keep it below {context['max_length']} characters"
        return "P106", f"{_got(value)} is malformed", hint
    if sort == "string_too_short":
        silent = "write [] for a silent letter" if "to" in loc[-2:] else ""
        return "P116", f"{subject} is empty", silent or "write a value, or delete the field"
    if sort == "literal_error":
        return _literal(subject, value, context["expected"])
    if sort.startswith("P1"):
        must = report["msg"].startswith("must ")
        got = _got(context.get("got", value))
        what = f"{subject} {report['msg']}, got {got}" if must else report["msg"]
        return sort, what, context.get("hint", "")
    return "P103", f"{subject}: {report['msg'][:1].lower()}{report['msg'][1:]}", ""


def _literal(subject: str, value: Data, expected: str) -> tuple[str, str, str]:
    # pydantic lists them as "'a', 'b' or 'c'"
    words = [w.strip("'") for w in expected.replace(" or ", ", ").split(", ")]
    choice = "one of " if len(words) > 1 else ""
    what = f"{subject} must be {choice}{', '.join(words)}, got {_got(value)}"
    if value == words[0]:  # text in the place of a number
        return "P107", what, "write it without quotes"
    hint = did_you_mean(value, words) if isinstance(value, str) else ""
    return "P107", what, hint if hint.startswith("did") else ""


def _length(source: YamlSource, loc: Loc, report: PydanticError) -> tuple[str, str, str]:
    """Return the fault of a list or mapping with too few or too many items."""
    sort, value, context = report["type"], report["input"], report.get("ctx", {})
    if sort == "missing":
        # pydantic points to the item that is missing, so the list is one step up
        need = f"more than {len(value)}"
        loc = loc[:-1]
    elif sort == "too_short":
        need = f"at least {context['min_length']}"
    else:
        need = f"at most {context['max_length']}"
    return "P108", f"{_subject(source, loc)} must have {need} items, got {len(value)}", ""


def _mend(sort: str, value: Data, *, needed: bool) -> str:  # noqa: PLR0911 one return for each cure
    # YAML knows no wide colon: a key and its value became one text
    if isinstance(value, str) and "：" in value:
        return f"{NO_COLON}: write `{re.sub('： *', ': ', value, count=1)}`"
    if sort == "string_type" and not isinstance(value, (tuple, dict, NoneType)):
        return "put it in quotes"
    if value is None:
        deleted = "" if needed else ", or delete the field"
        return f"write a value{deleted}; text after ' #' is a comment"
    if sort == "bool_type" and isinstance(value, str):
        return "write true or false"
    if sort == "float_type" and isinstance(value, str):
        return "write a point, not a comma" if "," in value else "write a number, such as 0.5"
    if sort in ("tuple_type", "list_type") and isinstance(value, str):
        return f"write [{', '.join(value.replace(',', ' ').split())}]"
    if sort in ("tuple_type", "list_type"):
        return "write names in brackets, as in [one, two], or values by name, as in {one: 1}"
    return ""


def _subject(source: YamlSource, loc: Sequence[str | int]) -> str:
    """Name the value at `loc` for a message: the nearest key, and items counted from 1."""
    steps: list[str | int] = []
    for number, step in enumerate(loc):
        around = source.at(loc[:number])
        if isinstance(around, tuple):
            around = range(len(around))
        # Pydantic's locations have steps of its own, which the file does not have.
        # a step in `<...>` is the tag of a union
        known = isinstance(around, (dict, range)) and step in around
        if (known or number == len(loc) - 1) and not str(step).startswith("<"):
            steps.append(step)
    items = ""
    while steps and isinstance(step := steps[-1], int):
        items += f"item {step + 1} of "
        steps.pop()
    return f"{items}`{steps[-1]}`" if steps else "the pack"


def _got(value: Data) -> str:
    """Describe a value for a message."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return f"number {float(value):g}"
    if isinstance(value, str):
        short = value if len(value) <= MAX_QUOTED_CHARS else value[: MAX_QUOTED_CHARS - 3] + "..."
        return f"text {short!r}"
    return "a mapping" if isinstance(value, dict) else "a list"


def _elsewhere(loc: Loc) -> str:
    """Say which kinds of files have an unknown field at the top; empty if none or many do."""
    kinds = [kind for kind, made in MODELS.items() if len(loc) == 1 and loc[0] in made.model_fields]
    # a field of many kinds says nothing about the file that was meant
    if not 1 <= len(kinds) <= MAX_KINDS:
        return ""
    extended = any("extends" in MODELS[kind].model_fields for kind in kinds)
    more = "; one that `extends` its own name adds to it" if extended else ""
    return f"`{loc[0]}` is a field of files of the kind {' or '.join(kinds)}{more}"


def _fields(model: type[BaseModel], loc: Loc, *, required: bool = False) -> dict[str, str]:
    """Return descriptions of the fields beside the last step of `loc`, by name in the file."""
    types: list[Data] = [model]
    for step in loc[:-1]:
        # a step of pydantic's own leads nowhere, and the types stay
        types = [t for kind in types for t in _inside(kind, step)] or types
    found: dict[str, str] = {}
    for kind in _flat(types):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            texts = descriptions(kind)
            fields = [
                (n, f) for n, f in kind.model_fields.items() if f.is_required() or not required
            ]
            # files have the alias
            found |= {f.alias or n: texts.get(n, "") for n, f in fields}
    return found


def _flat(types: Sequence[Data]) -> list[Data]:
    """Return the plain types within annotations and unions."""
    flat: list[Data] = []
    for kind in types:
        origin: Data = get_origin(kind)
        if origin is Annotated:
            flat += _flat(get_args(kind)[:1])
        elif origin in (Union, UnionType):
            flat += _flat(get_args(kind))
        else:
            flat.append(kind)
    return flat


def _inside(kind: Data, step: str | int) -> list[Data]:
    """Return the types of a value one step down; empty for a step that pydantic inserted."""
    inside: list[Data] = []
    for part in _flat([kind]):
        if isinstance(part, type) and issubclass(part, BaseModel):
            fields = {f.alias or name: f for name, f in part.model_fields.items()}
            if step in fields:
                inside.append(fields[str(step)].annotation)
            continue
        origin: Data = get_origin(part)
        if origin is dict:
            inside.append(get_args(part)[1])
        elif origin is tuple and isinstance(step, int):
            inside += [a for a in get_args(part) if a is not Ellipsis]
    return inside
