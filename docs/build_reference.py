"""Write the pages of `docs/reference` that repeat what the code and the built-in languages say.

    python docs/build_reference.py

`tests/docs/test_docs.py` makes them again and compares, and the list of languages in the README
too. The pages depend on nothing else: not on the width of a terminal, the version of Python, or
the packs in other folders.
"""

import argparse
import ast
import inspect
import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache, cached_property
from itertools import pairwise
from pathlib import Path
from types import FunctionType
from typing import Any, get_args, get_type_hints

from draw_house import graph, ordered, sources
from ipa_comparison import SymbolMappings, UnusualMapping, compare

import lipsync_lang as ll
from lipsync_lang.animations.animation_readers import ANIMATION_READERS
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.extensions import PROGRAM, F, Formats
from lipsync_lang.cli import parser
from lipsync_lang.commands.registry import leaves
from lipsync_lang.faces.rigs.recognise import losses
from lipsync_lang.packs.describe import schema
from lipsync_lang.packs.extending import REPLACED_FIELDS
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Language, PoseSet
from lipsync_lang.packs.yaml.faults import fault_codes
from lipsync_lang.pipeline import motion
from lipsync_lang.reports.coverage.report import schema as coverage_schema
from lipsync_lang.reports.quality.measures import load_measures
from lipsync_lang.schedules.timing_readers import TIMING_READERS
from lipsync_lang.text.lines.line_readers import LINE_READERS

HERE = Path(__file__).parent / "reference"
README = Path(__file__).parents[1] / "README.md"
INDEX = Path(__file__).parent / "README.md"
DEVELOPMENT = Path(__file__).parent / "contributing" / "development.md"
COVERAGE_SCHEMA = HERE / "coverage.schema.json"
MADE = "<!-- Written by docs/build_reference.py; change the code, then run that. -->\n"

Schema = dict[str, Any]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(_cell(c) for c in line) + " |" for line in lines)


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


# Commands


def commands() -> str:
    """Describe every command of the parser."""
    top = parser()
    parts = [
        "# Commands",
        (
            f"`lipsync-lang`: {_first_small(top.description or '')} "
            "Data goes to standard output, messages to standard error. The exit code is 0 if "
            "there are no faults, 1 if there are faults, and 2 if the command was wrong or could "
            "not be carried out. `lipsync-lang COMMAND --help` prints the text of this page. "
            "`lipsync-lang` alone prints the next steps in the current folder."
        ),
        table(
            ("command", "purpose"),
            [
                (f"[`{' '.join(path)}`](#{'-'.join(path)})", made.description or "")
                for path, made in leaves(top)
            ],
        ),
    ]
    for path, made in leaves(top):
        parts += [f"## {' '.join(path)}", made.description or "", _usage(path, made)]
        rows = [(_called(a), _explained(a)) for a in _arguments(made)]
        if rows:
            parts.append(table(("argument", "meaning"), rows))
        if made.epilog:
            title, _, example = made.epilog.partition("\n")
            parts.append(f"{title.capitalize()}\n\n```text\n{inspect.cleandoc(example)}\n```")
    return "\n\n".join(parts)


def _first_small(text: str) -> str:
    return text[:1].lower() + text[1:]


def _arguments(made: argparse.ArgumentParser) -> list[argparse.Action]:
    hidden = (argparse._HelpAction, argparse._SubParsersAction)  # noqa: SLF001
    return [a for a in made._actions if not isinstance(a, hidden)]  # noqa: SLF001


def _value(action: argparse.Action) -> str:
    if action.nargs == 0:
        return ""
    if action.choices and not action.metavar:
        return "{" + ",".join(map(str, action.choices)) + "}"
    return str(action.metavar or action.dest.upper())


def _usage(path: Sequence[str], made: argparse.ArgumentParser) -> str:
    words = []
    positional = [a for a in _arguments(made) if not a.option_strings]
    for action in (*positional, *(a for a in _arguments(made) if a.option_strings)):
        name = min(action.option_strings, key=len, default="")
        word = f"{name} {_value(action)}".strip()
        repeated = isinstance(action, argparse._AppendAction)  # noqa: SLF001
        more = "..." if repeated or action.nargs in ("*", "+") else ""
        optional = not action.required if name else action.nargs in ("?", "*")
        words.append(f"[{word}]{more}" if optional else f"{word}{more}")
    lines, start = [], f"lipsync-lang {' '.join(path)}"
    line = start
    for word in words:
        if len(line) + 1 + len(word) > 88:  # noqa: PLR2004 columns
            lines.append(line)
            line = " " * len(start)
        line += f" {word}"
    return "```text\n" + "\n".join([*lines, line]) + "\n```"


def _called(action: argparse.Action) -> str:
    value = _value(action)
    names = [f"{name} {value}".strip() for name in action.option_strings] or [value]
    return ", ".join(f"`{name}`" for name in names)


def _explained(action: argparse.Action) -> str:
    told = action.help or ""
    if action.choices and action.metavar is None and not told:
        told = "one of these"
    return told if not (action.required and action.option_strings) else f"{told} (required)"


# Packs

ORDER = ("language", "poseset", "bank", "character", "rig", "phonemes", "ipa", "project", "readout")

WHERE = {
    "language": "`languages/NAME.yaml`",
    "poseset": "`posesets/NAME/poseset.yaml`",
    "bank": "`posesets/POSESET/banks/NAME.yaml`, or beside a character that names it",
    "character": "`characters/NAME.yaml`",
    "rig": "`posesets/POSESET/rigs/NAME.yaml`",
    "phonemes": "`languages/common.yaml`",
    "ipa": "`languages/ipa.yaml`",
    "project": "`lipsync.yaml`, in a project's folder",
    "readout": "`readout.yaml`, beside captures",
}

JOINED_FIELDS = {
    "notations": "by label: a label of the child replaces that of the parent in any spelling",
    **dict.fromkeys(
        ("adds", "durations", "examples", "reasons"),
        "by entry: an entry of the child replaces that of the parent",
    ),
    "words": "by word; `null` leaves an inherited word to the engine",
    "text": "by field; mappings in it by entry, and its lists as a whole",
    "g2p": (
        "lists by item, the child's first; other fields as stated by the child, else the parent. A "
        "child with another engine, voice, code or file, or with `replace`, has its own alone"
    ),
    "silence": "both",
    **dict.fromkeys(REPLACED_FIELDS, "the child's if stated, else the parent's"),
    "tests": "the child's alone; a child of its parent's name keeps the others, too",
    **dict.fromkeys(
        ("format", "name", "title", "kind", "tag", "aliases", "extends", "inventory", "caveats"),
        "the child's alone",
    ),
}
"""Ways in which `extends` joins each field."""

EXAMPLES = {
    path.relative_to(HERE / "example").as_posix(): path.read_text("utf-8")
    for path in sorted((HERE / "example").rglob("*.yaml"))
}
"""A small project with one pack of each kind that people write; the tests validate it."""


def packs() -> str:
    """Describe every field of every kind of pack."""
    parts = [
        "# Packs",
        (
            "Packs are YAML files. Each starts with `kind`, `format: 1` and `name`, which is the "
            "file's name without `.yaml`, or the folder's. `lipsync-lang validate` checks them; "
            "`lipsync-lang schema KIND` prints the same as this page as JSON Schema, for editors "
            "that complete and check while you type. [Faults](faults.md) explains the codes in "
            "messages."
        ),
        (
            "Packs are searched in this order:\n\n"
            "1. the folders given with `--path`\n"
            "2. the folders of the environment variable `LIPSYNC_LANG_PATH`\n"
            "3. the current folder\n"
            "4. installed distributions with the entry point group `lipsync_lang.packs`\n"
            "5. the built-in packs"
        ),
        (
            "The first pack of a name shadows the others, and `list` shows which. Banks and rigs "
            "add up instead: a folder `posesets/NAME/banks` joins those of the pose set of that "
            "name, and an entry that is found earlier takes precedence."
        ),
    ]
    for kind in ORDER:
        whole = schema(kind)
        own = [path for path, text in EXAMPLES.items() if f"kind: {kind}\n" in text]
        parts += [f"## {kind}", f"{whole['description']} In {WHERE[kind]}."]
        parts += [f"```yaml\n# {path}\n{EXAMPLES[path]}```" for path in own]
        parts.append(_fields(whole, kind))
        if kind == "language":
            rows = [(f"`{name}`", JOINED_FIELDS[name]) for name in whole["properties"]]
            parts += ["### How `extends` joins each field", table(("field", "joined"), rows)]
        for name, part in sorted(whole.get("$defs", {}).items()):
            parts += [f"### {name}, in {kind}", part.get("description", ""), _fields(part, kind)]
    return "\n\n".join(parts)


def _fields(part: Schema, kind: str) -> str:
    """List the fields of a model."""
    needed = part.get("required", [])
    rows = [
        (
            f"`{name}`",
            _form(field, kind),
            "required" if name in needed else _default(field),
            field.get("description", ""),
        )
        for name, field in part["properties"].items()
    ]
    return table(("field", "form", "default", "meaning"), rows)


def _default(field: Schema) -> str:
    value = field.get("default")
    if isinstance(value, dict):
        return "see its fields" if value else "empty"
    if value is None or value == []:
        return "not set"
    return f"`{value}`" if value != "" else "empty"


def _form(field: Schema, kind: str) -> str:  # noqa: C901, PLR0911 a line for each form
    """Say in a few words what a value looks like."""
    if "$ref" in field:
        name = field["$ref"].rsplit("/", 1)[-1]
        return f"[{name}](#{name.lower()}-in-{kind})"
    if "const" in field:
        return f"`{field['const']}`"
    if "enum" in field:
        return ", ".join(f"`{word}`" for word in field["enum"])
    forms = field.get("anyOf") or field.get("oneOf")
    if forms:
        told = dict.fromkeys(_form(one, kind) for one in forms if one.get("type") != "null")
        return " or ".join(told)
    match field.get("type"):
        case "array" if "prefixItems" in field:
            return "[" + ", ".join(_form(one, kind) for one in field["prefixItems"]) + "]"
        case "array":
            return f"list of {_form(field.get('items', {}), kind)}"
        case "object" if "additionalProperties" in field:
            return f"mapping to {_form(field['additionalProperties'], kind)}"
        case "object" if "patternProperties" in field:
            inner = next(iter(field["patternProperties"].values()))
            return f"mapping to {_form(inner, kind)}"
        case "string":
            return "text"
        case "number" | "integer":
            return _number(field)
        case other:
            return str(other or "anything")


def _number(field: Schema) -> str:
    bounds = [
        f"{word} {field[key]:g}"
        for key, word in (
            ("minimum", "from"),
            ("exclusiveMinimum", "above"),
            ("maximum", "to"),
            ("exclusiveMaximum", "below"),
        )
        if key in field
    ]
    return " ".join(["number", *bounds])


# Languages

COUNTED = {
    "languages": re.compile(r"\d+(?= languages\b|, or yours)"),
    "pose sets": re.compile(r"\d+(?= pose sets\b)"),
}
"""Numbers in the README and the index, by the things that they count."""
"""Engines that read text, in words."""


@cache
def known() -> tuple[Language, ...]:
    """Return the built-in languages by title."""
    library = Library(project=None)
    found = [one for one in library.names("language") if one.path.is_relative_to(built_in())]
    models = (library.language(one.name).model for one in found)
    return tuple(sorted(models, key=_titled))


def _titled(model: Language) -> str:
    return model.title or model.name


def languages() -> str:
    """List every built-in language."""
    return "\n\n".join(
        [
            "# Languages",
            (
                "These languages have a pack. Each has tests, which are words from a source "
                "outside this program with their phonemes there, and "
                "[known errors](known-errors.md). `lipsync-lang languages show NAME` prints one "
                "language as a table of its sounds, their mouths, and the reasons."
            ),
            (
                "A language without a pack works as `-l espeak:CODE` or `-l epitran:CODE`, if "
                "eSpeak NG or Epitran reads it. With sounds in IPA, timed or as the text, every "
                "language works as `-l ipa:CODE`. For better results, "
                "[add a language](../tutorial/add-a-language.md)."
            ),
            table(
                (
                    "language",
                    "name",
                    "tag",
                    "other names",
                    "text is read by",
                    "spoken by",
                    "tests",
                    "known errors",
                ),
                [
                    (
                        _titled(model),
                        f"`{model.name}`",
                        f"`{model.tag}`",
                        ", ".join(model.aliases) or "-",
                        _read_by(model),
                        _spoken_by(model),
                        str(len(model.tests)),
                        f"[{len(model.caveats)}](known-errors.md#{_anchor(model)})"
                        if model.caveats
                        else "-",
                    )
                    for model in known()
                ],
            ),
        ]
    )


def known_errors() -> str:
    """List the known errors of every built-in language."""
    faulty = [model for model in known() if model.caveats]
    sound = ", ".join(_titled(model) for model in known() if not model.caveats)
    return "\n\n".join(
        [
            "# Known errors of the languages",
            (
                "Each language pack states under `caveats` the text that is read wrongly, and what "
                "helps. `lipsync-lang languages show NAME` prints these notes too. To mend a word, "
                "[pronounce it](../how-to/pronounce-a-word.md). "
                f"The packs of these languages name no error: {sound}."
            ),
            *(
                "\n\n".join(
                    [f"## {_titled(model)}", "\n".join(f"- {one}" for one in model.caveats)]
                )
                for model in faulty
            ),
        ]
    )


def _anchor(model: Language) -> str:
    """Return the anchor of a language's heading."""
    return re.sub(r"[^\w\- ]", "", _titled(model).lower()).replace(" ", "-")


# The IPA in all languages


def ipa_table() -> str:
    """Compare how all languages map each symbol of the IPA."""
    titles = {model.name: _titled(model) for model in known()}
    rows = [one for one in compare(Library(project=None)) if len(_mapping(one)) > 1]
    return "\n\n".join(
        [
            "# The IPA in all languages",
            (
                "This table shows the mapping of each symbol that two or more packs have. The "
                "usual mouth is that of most packs. The last column lists the other mouths, with "
                'the reasons of the packs. A reason such as "as ə" follows from another row: the '
                "symbol is mapped like its letters. Mouths are the common phonemes and shades of "
                "[`common.yaml`](../../languages/common.yaml); "
                "[how sounds find their mouth shapes](../explanation/mapping.md) explains them. "
                "`lipsync-lang languages show NAME` prints one language in full."
            ),
            table(
                ("symbol", "usual mouth", "languages", "other mouths, and why"),
                [
                    (
                        f"`{row.symbol}`",
                        _mouths(row.usual),
                        str(len(row.languages)),
                        "; ".join(_otherwise(one, titles) for one in row.unusual) or "-",
                    )
                    for row in rows
                ],
            ),
        ]
    )


def _mapping(row: SymbolMappings) -> list[str]:
    """Return the packs that map a symbol."""
    return [*row.languages, *(name for one in row.unusual for name in one.languages)]


def _mouths(to: Sequence[str]) -> str:
    return f"`{' '.join(to)}`" if to else "silent"


def _otherwise(one: UnusualMapping, titles: Mapping[str, str]) -> str:
    names = ", ".join(titles[name] for name in one.languages)
    return f"{_mouths(one.to)} in {names}: {one.reason}"


# Pose sets


def posesets() -> str:
    """Describe every built-in pose set, with what its rigs lose and a sheet of its model."""
    library = Library(project=None)
    models = [library.poseset(found.name).model for found in library.names("poseset")]
    parts = [
        "# Pose sets",
        (
            "These faces come with the program. Each has targets for every common phoneme, so it "
            "speaks every language with drafted bigrams. `lipsync-lang posesets show NAME` prints "
            "its constraints, priorities and contacts. A character of your own may use any of "
            "them, with [bigrams of its own](../how-to/edit-a-bigram.md) and "
            "[your model](../how-to/put-it-on-your-character.md). If none resembles your face, "
            "[add a pose set](../tutorial/add-a-pose-set.md)."
        ),
        table(
            ("pose set", "name", "poses", "edited bigrams", "shown", "rigs onto"),
            [
                (
                    model.title,
                    f"[`{model.name}`](#{model.name})",
                    str(len(model.poses)),
                    str(sum(len(bank.model.bigrams) for bank in library.banks(model.name))),
                    "one at a time" if model.motion.hold else "blended",
                    ", ".join(rig.model.to or rig.model.name for rig in library.rigs(model.name))
                    or "-",
                )
                for model in models
            ],
        ),
    ]
    for model in models:
        parts += [f"## {model.name}", _rest(model)]
        if (HERE.parent / "images" / f"{model.name}-poses.png").is_file():
            sheet = f"../images/{model.name}-poses.png"
            parts.append(f"![Every pose of {model.title} on its model, alone]({sheet})")
        groups = {
            "pose": model.poses,
            "pose that few models have": model.optional_poses,
            "pose of gestures": model.gesture_poses,
        }
        for heading, own in groups.items():
            rows = [(f"`{name}`", pose.region, pose.title) for name, pose in own.items()]
            if rows:
                parts.append(table((heading, "region", "shape"), rows))
        for rig in library.rigs(model.name):
            lost = losses(library, rig)
            told = [(f"`{one.pose}`", f"{one.shown:.2f}", one.what, one.why) for one in lost]
            head = ("lost", "shown", "how", "why")
            parts += [f"**{rig.model.title or rig.model.name}** (`{rig.model.name}`)"]
            parts.append(table(head, told) if told else "This rig shows every pose.")
    return "\n\n".join(parts)


def _rest(model: PoseSet) -> str:
    """Describe the contacts and the pose at rest of a pose set."""
    contacts = [
        f"{name} for {' '.join(f'`{label}`' for label in contact.phonemes)}"
        for name, contact in model.contacts.items()
    ]
    parts = [f"{model.title}. Contacts: {', '.join(contacts) or 'none'}."]
    if model.neutral:
        parts.append(f"The pose at rest is `{model.neutral}`.")
    return " ".join(parts)


def _read_by(model: Language) -> str:
    g2p = model.g2p
    if g2p is None:
        return "-"
    parts = [
        f"{g2p.engine} {g2p.voice or g2p.code or ''}".strip(),
        f"{len(g2p.rules)} of them" if g2p.rules and g2p.engine == "rules" else "",
        f"{len(g2p.rules)} rules" if g2p.rules and g2p.engine != "rules" else "",
        f"respelled as {g2p.respell}" if g2p.respell else "",
    ]
    return ", ".join(filter(None, parts))


def _spoken_by(model: Language) -> str:
    return " ".join(filter(None, (model.tts.engine, model.tts.voice))) if model.tts else "-"


def readme(text: str) -> str:
    """Return the README with its numbers of languages and pose sets as the packs are now."""
    library = Library(project=None)
    posesets = len({found.name for found in library.names("poseset")})
    # A pack with a private tag is another mapping of a language that has a pack.
    counted = sum("-x-" not in model.tag for model in known())
    text = COUNTED["languages"].sub(str(counted), text)
    return COUNTED["pose sets"].sub(str(posesets), text)


# The house

MAP = re.compile(r"(?<=```text\n)lipsync_lang/\n.*?(?=```)", re.DOTALL)
"""The map of the package in the page for developers."""


def development(text: str) -> str:
    """Return the page for developers with a map of the folders and modules as they are now."""
    return MAP.sub(lambda _: house_map(Path(ll.__file__).parent), text)


def house_map(package: Path) -> str:
    """List the wings from the roof to the ground, and their rooms, each with its summary."""
    wings = ordered(graph(dict(sources(None))))
    rows = []
    for wing in wings:
        base = package / wing
        loose = base.glob("*.py") if wing == wings[-1] else ()
        rooms = [path.parent for path in base.glob("*/__init__.py")]
        rooms += [path for path in loose if path.name != "__init__.py"]
        for path in [base if base.is_dir() else base.with_suffix(".py"), *sorted(rooms)]:
            source = path / "__init__.py" if path.is_dir() else path
            summary = ast.get_docstring(ast.parse(source.read_bytes())).splitlines()[0].rstrip(".")
            place = path.relative_to(package)
            name = "  " * len(place.parts) + place.name + "/" * path.is_dir()
            rows.append(f"{name:<20} {summary}")
    return "\n".join(["lipsync_lang/", *rows, ""])


# Faults

GROUPS = {
    "P0": "The file as YAML",
    "P1": "The form of one pack",
    "P2": "Contradictions between parts",
    "P4": "A project and its build",
    "W3": "Warnings: valid, but probably a mistake",
}


def faults() -> str:
    """Describe every code, with its cause and its cure."""
    parts = [
        "# Faults",
        "A fault names its place, the problem and the cure:",
        (
            "```text\nlanguages/stage-english.yaml:7:16: P202 unknown phoneme 'bpm'\n"
            "  hint: did you mean 'bmp'?\n```"
        ),
        (
            "A code never changes its meaning. A pack with a P code is refused, unless the code is "
            "about what the pack claims: its tests (P221) or its inventory (P220). A W code is a "
            "warning, and the pack stays valid."
        ),
    ]
    for start, title in GROUPS.items():
        parts.append(f"## {title}")
        for code, told in fault_codes().items():
            if code.startswith(start):
                lines = (told.meaning, f"- Cause: {told.cause}", f"- Cure: {told.cure}")
                parts += [f"### {code}", f"{lines[0]}\n\n{lines[1]}\n{lines[2]}"]
    grouped = sum(code[:2] in GROUPS for code in fault_codes())
    if grouped != len(fault_codes()):
        raise ValueError("a fault code belongs to no group of this page")
    return "\n\n".join(parts)


# Motion


def motions() -> str:
    """Describe every motion setting, with its value in each preset."""
    told = _attribute_docstrings(motion)
    hints = get_type_hints(motion.Motion)
    names = list(motion.PRESETS)
    rows = [
        (
            f"`{field.name}`",
            ", ".join(f"`{choice}`" for choice in get_args(hints[field.name])) or "number",
            *(f"`{getattr(motion.PRESETS[name], field.name)}`" for name in names),
            told[field.name],
        )
        for field in fields(motion.Motion)
    ]
    return "\n\n".join(
        [
            "# Motion settings",
            (
                "These settings control how curves become motion. You can change a setting in "
                "four places; each overrides the one before:\n\n"
                "1. `motion` of a pose set\n"
                "2. `motion` of a language: `paper-english` has the paper's\n"
                "3. `motion` of a character\n"
                "4. a call: `--set motion.window=0.1` on the command line, "
                '`resolve(..., motion={"window": 0.1})` or '
                '`performer.with_motion({"window": 0.1})` in Python'
            ),
            (
                "A preset replaces all settings at once: `--set motion=paper`, "
                '`motion="paper"`, or `preset: paper` in a pack. [Curves](curves.md) explains the '
                "stages, and [tune the motion](../how-to/tune-the-motion.md) helps you choose."
            ),
            table(("setting", "values", *(f"in `{n}`" for n in names), "meaning"), rows),
            f"`PRESETS`: {told['PRESETS']}",
        ]
    )


def _attribute_docstrings(module: Any) -> dict[str, str]:
    """Return the strings that follow assignments, by the name assigned to."""
    told: dict[str, str] = {}
    for scope in ast.walk(ast.parse(inspect.getsource(module))):
        body = getattr(scope, "body", None)
        if not isinstance(body, list):
            continue
        for said, text in pairwise(body):
            named = said.target if isinstance(said, ast.AnnAssign) else None
            if isinstance(said, ast.Assign):
                named = said.targets[0]
            if isinstance(named, ast.Name) and isinstance(text, ast.Expr):
                told[named.id] = inspect.cleandoc(ast.literal_eval(text.value))
    return told


# Checks


def checks() -> str:
    """Describe every measure of a finished animation."""
    measures = load_measures().values()
    parts = [
        "# Checks",
        (
            "`lipsync-lang check` computes these measures of a finished animation "
            "([check an animation](../how-to/check-an-animation.md)). A smaller value is better. "
            "You can state a limit in three places; each overrides the one before:\n\n"
            "1. `checks` of a pose set\n"
            "2. `checks` of a character\n"
            '3. a call: `--limit jitter=3`, or `check(animation, limits={"jitter": 3})`'
        ),
        ("A value that exceeds its limit by at most a thousandth, which is rounding, passes."),
        table(
            ("measure", "unit", "default limit", "meaning"),
            [
                (f"[`{one.name}`](#{one.name})", one.unit, _limit(one.name, one.limit), _first(one))
                for one in measures
            ],
        ),
        (
            "Curves are those of poses, from 0 to 1. For the channels of a rig, values are "
            "fractions of a channel's range, constraints are those between channels, and rules "
            "are not judged. A sound is a phoneme that is not silence; its bounds are those of its "
            "common phonemes. [Packs](packs.md#measurerule-in-poseset) describes `MeasureRule`, "
            "with its phonemes, measure and bounds."
        ),
    ]
    for one in measures:
        said, _, formula = inspect.cleandoc(one.told).rpartition("::\n")
        told = f"{said.rstrip().removesuffix('It is').rstrip().removesuffix('.')}:"
        parts += [f"## {one.name}", told, f"```text\n{inspect.cleandoc(formula)}\n```"]
    return "\n\n".join(parts)


def _limit(name: str, limit: float | None) -> str:
    if name == "speed":
        return "the motion's `speed_limit`"
    return "none" if limit is None else f"{limit:g}"


def _first(measure: Any) -> str:
    return inspect.cleandoc(measure.told).partition("\n")[0]


# Python API


def api() -> str:
    """Describe the public names of the package.

    The site replaces the text between the comments of a name by its whole documentation.
    """
    public = {name: getattr(ll, name) for name in ll.__all__ if name != "__version__"}
    kinds: dict[str, list[str]] = {"Functions": [], "Classes": [], "Errors": []}
    for name, named in public.items():
        kinds[_kind(named)].append(name)
    parts = [
        "# Python API",
        (
            "The public names of the package, `import lipsync_lang as ll`. How to use them is in "
            "[use it from Python](../how-to/use-from-python.md). Other modules are not public: "
            "their names may change in any release. Times are in seconds, and weights of poses "
            "are from 0 to 1."
        ),
        table(
            ("name", "summary"),
            [(f"[`{name}`](#{name.lower()})", _summary(named)) for name, named in public.items()],
        ),
    ]
    for title, names in kinds.items():
        parts += [f"## {title}", *(_documented(name, public[name]) for name in names)]
    return "\n\n".join(parts)


_MEMBERS = (FunctionType, classmethod, staticmethod, property, cached_property)


def _kind(named: Any) -> str:
    if not inspect.isclass(named):
        return "Functions"
    return "Errors" if issubclass(named, Exception) else "Classes"


def _summary(named: Any) -> str:
    return inspect.cleandoc(named.__doc__).partition("\n\n")[0]


def _members(named: Any) -> dict[str, Any]:
    """Return the members of a class of the package, those that it inherits from another first."""
    classes = reversed(named.__mro__) if inspect.isclass(named) else ()
    ours = [vars(one) for one in classes if one.__module__.startswith("lipsync_lang.")]
    return {key: value for members in ours for key, value in members.items()}


def _documented(name: str, named: Any) -> str:
    """Return a section about a name, with a table of its methods."""
    methods = [
        (f"`{key}`", _summary(value))
        for key, value in _members(named).items()
        if not key.startswith("_")
        if isinstance(value, _MEMBERS) and value.__doc__
    ]
    parts = [f"<!-- api: {named.__module__}.{name} -->", f"### {name}", _summary(named)]
    parts += [table(("member", "summary"), methods)] if methods else []
    return "\n\n".join([*parts, "<!-- end -->"])


# Formats


def shipped(formats: Formats[F]) -> list[F]:
    """Return the formats that come with the program, not those of other installed plug-ins."""
    return [one for name, one in formats.items() if formats.origins[name] == PROGRAM]


DOCUMENTED_FORMS = (
    (
        "allosaurus",
        "rows of `--timestamp=True`",
        "[Allosaurus, README](https://github.com/xinjli/allosaurus#readme)",
    ),
    (
        "aws-transcribe",
        "`results.items` of a batch job",
        "[Amazon Transcribe, output](https://docs.aws.amazon.com/transcribe/latest/dg/how-input.html)",
    ),
    (
        "deepgram",
        "words of recorded speech",
        "[Deepgram, pre-recorded audio](https://developers.deepgram.com/docs/pre-recorded-audio)",
    ),
    (
        "google, google-v2, google-timepoints",
        "word offsets of both versions, and time points of marks",
        (
            "[Speech-to-Text, time offsets](https://cloud.google.com/speech-to-text/docs/"
            "async-time-offsets), [Text-to-Speech, time points](https://cloud.google.com/"
            "text-to-speech/docs/reference/rest/v1beta1/text/synthesize)"
        ),
    ),
    (
        "gladia, rev, speechmatics, word-times",
        "words with their times",
        "the examples of answers in the documents of each service, and of NeMo and Kokoro-FastAPI",
    ),
    (
        "julius",
        "the log of `-palign` and `-walign`",
        (
            "`segment_julius.pl` of [Julius's kit](https://github.com/julius-speech/"
            "segmentation-kit), which moves all times but the first by 12.5 ms"
        ),
    ),
    (
        "kokoro, edge-tts, piper, piper-samples",
        "what `create_timed`, `save` and the server write; no voice was run",
        "the source of kokoro-onnx 0.6.1, edge-tts 7.3.1 and piper-tts 1.8.0",
    ),
    (
        "talking-head",
        "`visemes`, `vtimes`, `vdurations` and those of words",
        "[TalkingHead, README](https://github.com/met4citizen/TalkingHead#readme)",
    ),
    (
        "cslu",
        "the header, the frames and the labels of a `.phn`",
        (
            "`formats.txt` of the Portland Cellular Corpus (LDC2008S01); labels by Hieronymus, "
            '"ASCII Phonetic Symbols for the World\'s Languages: Worldbet" (1993)'
        ),
    ),
    (
        "facefx",
        "lists of phonemes and words; the names `FLAP` and `SHORTSIL`",
        (
            "[FaceFX, phonlist command]"
            "(https://facefx.github.io/documentation/doc/phonlist-command); the enumeration of its "
            "phonemes, versions of 2002 to 2009"
        ),
    ),
    (
        "sapi",
        "numbers of phonemes, and marks of stress and of boundaries",
        (
            "[American English Phoneme Representation]"
            "(https://learn.microsoft.com/previous-versions/windows/desktop/ee431828(v=vs.85)), "
            "[Phoneme event of SpVoice]"
            "(https://learn.microsoft.com/previous-versions/windows/desktop/ee125626(v=vs.85)), "
            "[PhonemeReachedEventArgs]"
            "(https://learn.microsoft.com/dotnet/api/"
            "system.speech.synthesis.phonemereachedeventargs)"
        ),
    ),
    (
        "cereproc",
        "events of phonemes and words; no voice of CereProc was run",
        (
            "header `cerevoice_eng.h` and example `basictts` of the CereVoice SDK; phones by the "
            "relay of SmartBody, whose replies `bml` reads"
        ),
    ),
)
"""Formats that were read by their documents alone, the part read, and its source."""


DOCUMENTED_SCRIPTS = (
    (
        "android-strings",
        "strings, plurals and arrays",
        "[String resources](https://developer.android.com/guide/topics/resources/string-resource)",
    ),
    (
        "arb",
        "texts in ICU's form",
        "[Application Resource Bundle](https://github.com/google/app-resource-bundle)",
    ),
    (
        "fluent",
        "messages, attributes, terms and selectors",
        (
            "[Fluent, syntax guide](https://projectfluent.org/fluent/guide/); names of messages as "
            "fluent.syntax 0.19 reads them"
        ),
    ),
    (
        "renpy",
        "say statements, and the identifiers of Ren'Py 8.0.3",
        "the parser of Debian's package `renpy`, run on a thousand statements",
    ),
    (
        "rpg-maker",
        "commands 101, 102, 105, 401 and 405 of events",
        "events of published games of MV",
    ),
    (
        "strings, stringsdict, xcstrings",
        "keys, comments and plurals",
        "[Xcode, localization](https://developer.apple.com/documentation/xcode/localization)",
    ),
    (
        "twee",
        "passages and links",
        (
            "[Twee 3 specification](https://github.com/iftechfoundation/twine-specs/blob/master/"
            "twee-3-specification.md)"
        ),
    ),
    (
        "unreal-archive, unreal-manifest",
        "namespaces, keys and texts",
        (
            "[Unreal, localization tools](https://dev.epicgames.com/documentation/unreal-engine/"
            "localization-tools-in-unreal-engine)"
        ),
    ),
    (
        "xliff",
        "units, segments, states, notes and inline codes",
        (
            "[XLIFF 1.2](https://docs.oasis-open.org/xliff/v1.2/os/xliff-core.html), "
            "[XLIFF 2.1](https://docs.oasis-open.org/xliff/xliff-core/v2.1/xliff-core-v2.1.html)"
        ),
    ),
)
"""Formats of scripts that were read by their documents, the part read, and its source."""


def formats() -> str:
    """List what can be read and written."""
    read = [
        (r.name, " ".join(f"`{s}`" for s in r.suffixes), r.title) for r in shipped(TIMING_READERS)
    ]
    judged = sorted((r.name, f"`{r.suffix}`", r.title) for r in shipped(ANIMATION_READERS))
    written = [(w.name, f"`{w.suffix}`", w.title) for w in shipped(WRITERS)]
    return "\n\n".join(
        [
            "# Formats",
            "The suffix of a file names its format. `lipsync-lang formats` prints these tables.",
            "## Read: timed phonemes",
            table(("name", "suffix", "content"), sorted(read)),
            (
                "See [schedules as JSON](schedule-json.md) and "
                "[use your own timings](../how-to/use-your-own-timings.md)."
            ),
            (
                "Some programs were not at hand. Their formats are read by their documents, and "
                "tests hold a file of each documented form:"
            ),
            table(("name", "read", "from"), DOCUMENTED_FORMS),
            "## Read: lines of a script, to be counted",
            table(
                ("name", "suffix", "content"),
                sorted(
                    (r.name, " ".join(f"`{s}`" for s in r.suffixes), r.title)
                    for r in shipped(LINE_READERS)
                ),
            ),
            "See [plan the work](../how-to/plan-the-work.md).",
            "These are read by their documents or the programs that write them:",
            table(("name", "read", "from"), DOCUMENTED_SCRIPTS),
            "## Read: animations, to be judged",
            table(("name", "suffix", "content"), judged),
            "See [check an animation](../how-to/check-an-animation.md).",
            "## Written: animations",
            table(("name", "suffix", "content"), sorted(written)),
            "See [animation files](animation-files.md).",
        ]
    )


PAGES = {
    "commands.md": commands,
    "languages.md": languages,
    "known-errors.md": known_errors,
    "ipa.md": ipa_table,
    "posesets.md": posesets,
    "packs.md": packs,
    "faults.md": faults,
    "motion.md": motions,
    "checks.md": checks,
    "formats.md": formats,
    "api.md": api,
}
"""The generated pages, and the function that writes each."""


@cache
def page(name: str) -> str:
    """Return the whole text of a generated page."""
    return f"{MADE}\n{PAGES[name]().strip()}\n"


if __name__ == "__main__":
    for name in PAGES:
        (HERE / name).write_text(page(name), encoding="utf-8")
        sys.stdout.write(f"{HERE / name}\n")
    for counted in (README, INDEX):
        counted.write_text(readme(counted.read_text(encoding="utf-8")), encoding="utf-8")
        sys.stdout.write(f"{counted}\n")
    DEVELOPMENT.write_text(development(DEVELOPMENT.read_text(encoding="utf-8")), encoding="utf-8")
    sys.stdout.write(f"{DEVELOPMENT}\n")
    document = json.dumps(coverage_schema(), indent=2, ensure_ascii=False) + "\n"
    COVERAGE_SCHEMA.write_text(document, encoding="utf-8")
    sys.stdout.write(f"{COVERAGE_SCHEMA}\n")
