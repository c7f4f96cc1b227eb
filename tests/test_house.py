"""The house: a room imports only from floors below, and data stays out of code."""

import ast
import re
import runpy
from collections import Counter, defaultdict
from functools import cache
from pathlib import Path

import pytest
from lanes import full
from shipped import LIBRARY

import lipsync_lang as ll

PACKAGE = Path(ll.__file__).parent


@cache
def modules():
    """Return the syntax tree of every module, by its path; parsing all of them takes seconds."""
    paths = sorted(PACKAGE.rglob("*.py"))
    assert paths, "a sweep over nothing passes"
    return {path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_bytes()) for path in paths}


# Arrows

FLOORS = (
    {"errors", "extras", "version", "terminal", "text_table"},
    {"extensions", "files"},
    {"phonology", "pipeline", "schedules"},
    {"lines", "packs"},
    {"banks", "rigs"},
    {"animations", "resolver"},
    {"speech"},
    {"performing"},
    {"coverage", "live", "quality", "render"},
    {"capture"},
    {"authoring"},
    {"build", "study"},
    {"studio"},
    {"commands"},
    {"cli"},
)
"""The house from the ground up. A room imports from the floors below it, never from its own."""

PACKS = ("yaml", "models", "", "checking")
"""Floors within `packs`; modules without a folder are between the models and the checks."""

ALONE = {
    "pipeline": set(),
    "phonology": {"errors", "extensions", "extras", "files"},
    "schedules": {"errors", "extensions", "files"},
}
"""Rooms that import less than their floor allows."""


def part(name):
    """Return the part of the house with a module."""
    return name.split("/")[0].removesuffix(".py")


def imports(tree):
    """Yield the full names of the package's modules that a module imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@cache
def arrows():
    """Return every import between rooms: the module, its room, and the room it imports from."""
    rooms = {part(name) for name in modules()}
    return [
        (name, part(name), steps[1])
        for name, tree in modules().items()
        for steps in (imported.split(".") for imported in imports(tree))
        if steps[0] == "lipsync_lang" and steps[1:2] and steps[1] in rooms - {part(name)}
    ]


def test_every_room_has_a_floor():
    rooms = {part(name) for name in modules()} - {"__init__", "__main__"}
    assert rooms == set().union(*FLOORS)


def test_arrows_run_downwards_only():
    floor = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
    floor |= {"__init__": len(FLOORS), "__main__": len(FLOORS)}
    upward = [arrow for arrow in arrows() if floor[arrow[2]] >= floor[arrow[1]]]
    assert not upward


@full
def test_the_picture_of_the_house_shows_these_arrows(root):
    drawn = runpy.run_path(str(root / "docs/draw_house.py"))
    rooms = drawn["graph"](dict(drawn["sources"](None)))
    assert {(here, there) for here in rooms for there in rooms[here]} == {
        (here, there) for _, here, there in arrows() if not here.startswith("__")
    }
    assert drawn["matrix"](rooms).endswith("in a ring: none")
    ring = {"one": {"other"}, "other": {"one"}}
    assert drawn["matrix"](ring).endswith("in a ring: one, other")


@pytest.mark.parametrize("room", ALONE)
def test_some_rooms_know_nearly_nothing(room):
    known = {there for _, here, there in arrows() if here == room}
    assert known <= ALONE[room]


def test_arrows_within_packs_run_downwards_only():
    def step(steps):
        return PACKS.index(steps[0] if steps[0] in PACKS else "")

    upward = []
    for name, tree in modules().items():
        if part(name) == "packs":
            here = step(name.split("/")[1:])
            for imported in imports(tree):
                steps = imported.split(".")
                if steps[:2] == ["lipsync_lang", "packs"] and step(steps[2:]) > here:
                    upward.append((name, imported))
    assert not upward


WRITES_SCHEDULES = "animations/performed_timings.py"
"""The only module of `animations` that may write schedules."""


def test_writers_know_only_the_schedule_itself():
    for name, tree in modules().items():
        if (
            part(name) == "animations" and name != "animations/performed_timings.py"
        ):  # it writes schedules
            for imported in imports(tree):
                if imported.startswith("lipsync_lang.schedules"):
                    assert imported == "lipsync_lang.schedules.schedule.Schedule", name


def test_what_runs_beside_the_program_imports_nothing_of_it():
    for name, tree in modules().items():
        if name.endswith("_worker.py"):
            assert not [i for i in imports(tree) if i.startswith("lipsync_lang")], name


# Data stays data


@cache
def names_of_packs():
    """Return every name that belongs in packs, with its kind."""
    found = {}
    common = LIBRARY.common().model
    found.update(dict.fromkeys((p for p in common.phonemes if len(p) > 1), "common phoneme"))
    found.update(dict.fromkeys(common.visemes, "notation"))
    for one in LIBRARY.names("poseset"):
        model = LIBRARY.poseset(one.name).model
        found.update(dict.fromkeys(model.poses, "pose"))
        found.update(dict.fromkeys((model.name, *model.contacts), "pose set"))
    for one in LIBRARY.names("language"):
        model = LIBRARY.language(one.name).model
        for table in model.notations.values():
            found.update(dict.fromkeys(filter(unmistakable, table), "label"))
        found.update(dict.fromkeys(model.notations, "notation"))
        found.update(dict.fromkeys((model.name, model.tag), "language"))
    told = {name: what for name, what in found.items() if len(name) > 1 or not name.isascii()}
    kinds = {"language", "pose", "pose set", "label", "common phoneme"}
    assert kinds <= set(told.values()), "a sweep over nothing passes"
    return told


def unmistakable(label):
    """Return True if a text can only be a label, such as `ʃ` and `HH`, but not `in` or `s`."""
    return not label.isascii() or (len(label) > 1 and label.isalpha() and label.isupper())


TOLD_APART = {"language", "pose set", "pose"}
"""Names that must not occur within longer text either."""

ORDINARY = {
    "open": "a verb",
    "wide": "an adjective",
    "lips": "a part of the face",
    "teeth": "a part of the face",
    "it": "a pronoun",
    "no": "a determiner",
    "is": "a verb",
    "or": "a conjunction",
    "as": "an adverb",
    "so": "an adverb",
    "id": "a number's name",
    "my": "a pronoun",
    "he": "a pronoun",
    "letters": "what words are made of",
}
"""Names of packs that are English words, which are searched for only as whole strings."""

EXEMPT = {
    ("animations/readers/csv.py", "ms"): "milliseconds, at the head of a column",
    ("commands/packs.py", "sw"): "an example in a message can be typed as it stands",
    ("commands/*_options.py", "english"): "the examples of --help can be typed as they stand",
    ("commands/*_options.py", "facefx"): "the examples of --help can be typed as they stand",
    ("commands/*_options.py", "finnish"): "the examples of --help can be typed as they stand",
    ("commands/*_options.py", "sw"): "the examples of --help can be typed as they stand",
    ("commands/parser.py", "english"): "the example of --help can be typed as it stands",
    ("commands/parser.py", "facefx"): "the example of --help can be typed as it stands",
    ("commands/*_options.py", "NG"): "eSpeak NG is the engine's name",
    ("phonology/g2p/thaiphon_g2p.py", "ipa"): "the library's name of its own output",
    ("packs/finding.py", "ipa"): "the file of the IPA, and its kind of pack",
    ("packs/models/ipa_models.py", "ipa"): "the kind of pack",
    ("packs/models/validation.py", "pt-BR"): "an example in a message",
    ("packs/checking/ipa_checks.py", "letters"): "a field of the IPA's pack",
    ("packs/checking/salvage.py", "letters"): "a field of the IPA's pack",
    ("phonology/ipa.py", "letters"): "a field of the IPA's pack",
    ("phonology/g2p/kana.py", "kana"): "the name of a respeller, after the script it writes",
    ("phonology/g2p/kana.py", "japanese"): "the name of the extra that installs it",
    ("phonology/g2p/pinyin.py", "mandarin"): "the name of the extra that installs it",
    ("phonology/g2p/pinyin.py", "roman"): "a kind of script, within the module",
    ("phonology/g2p/g2p_engines.py", "kana"): "the name of a respeller, after the script it writes",
    ("phonology/espeak/espeak_worker.py", "id"): "a field of the library's events",
    ("lines/columns.py", "id"): "what tables call the column of a line's name",
    ("packs/models/project_models.py", "id"): "a placeholder",
    ("commands/defaults.py", "id"): "a placeholder",
    ("build/new_project.py", "id"): "a field of the project",
    ("build/project_folder.py", "id"): "a field of the project",
    ("animations/azure.py", "azure"): "the name of the format",
    ("animations/rhubarb.py", "rhubarb"): "the program's name, and that of the set of its shapes",
    ("animations/smartbody.py", "smartbody"): "the name of the format",
    ("schedules/azure.py", "azure"): "the format, and the notation it is in",
    ("schedules/bml.py", "lips"): "an element of the format",
    ("schedules/bml.py", "smartbody"): "the notation that the format is in",
    ("schedules/emu.py", "id"): "a field of the format",
    ("schedules/json.py", "HH"): "the example of the format's form",
    ("schedules/papagayo.py", "preston-blair"): "the notation that the format is in",
    ("schedules/polly.py", "polly"): "the format, and the notation it is in",
    ("schedules/rhubarb.py", "rhubarb"): "the format, and the notation it is in",
    ("schedules/transcriber.py", "id"): "an attribute of the format",
    ("schedules/transcriber.py", "nb"): "an attribute of the format",
    ("schedules/sapi.py", "sapi"): "the name of the format",
    ("schedules/sapi.py", "sapi-visemes"): "the notation that the format is in",
    ("phonology/espeak/process.py", "NG"): "eSpeak NG is the engine's name",
    ("packs/checking/voices.py", "NG"): "eSpeak NG is the engine's name",
    ("speech/espeak.py", "NG"): "eSpeak NG is the engine's name",
    ("speech/espeak.py", "ipa"): "the notation that the engine itself writes",
    ("speech/festival.py", "arpabet"): "the notation that its phone sets are in",
    ("phonology/labels.py", "label"): "letters of the IPA that are typed for one another",
}
"""Reason for an exception by module and name; obsolete entries must be removed."""


def texts(tree):
    """Yield the strings of a module without docstrings and format codes."""
    told = {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.Expr)}
    codes = {
        id(inner)
        for n in ast.walk(tree)
        if isinstance(n, ast.FormattedValue) and n.format_spec
        for inner in ast.walk(n.format_spec)
    }
    for node in ast.walk(tree):
        text = isinstance(node, ast.Constant) and isinstance(node.value, str)
        if text and id(node) not in told | codes:
            yield node.value


def named(text):
    """Yield the names of packs in a string."""
    names = names_of_packs()
    if text in names:
        yield text
        return
    for word in set(re.findall(r"[\w-]+", text)):
        what = names.get(word)
        unmistaken = what == "label" and word.isascii()
        if len(word) > 1 and word not in ORDINARY and (what in TOLD_APART or unmistaken):
            yield word


def test_no_module_knows_the_name_of_a_language_a_phoneme_or_a_pose():
    names = names_of_packs()
    found = {
        (re.sub(r"\w+_options", "*_options", name), word)
        for name, tree in modules().items()
        for t in texts(tree)
        for word in named(t)
    }
    used = {
        key for name, word in found for key in ((name, word), (name, names[word])) if key in EXEMPT
    }
    loose = {
        (name, word)
        for name, word in found
        if (name, word) not in EXEMPT and (name, names[word]) not in EXEMPT
    }
    assert not loose, "names that belong into packs"
    assert used == set(EXEMPT), "cured: remove it from EXEMPT"


# Habits


def test_no_two_classes_share_a_name():
    places = defaultdict(list)
    for name, tree in modules().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(f"{name}:{node.lineno}")
    assert not {name: found for name, found in places.items() if len(found) > 1}


FORMATS = {"azure", "csv", "glb", "json", "moho", "rhubarb", "smartbody", "subtitles", "text"}
"""Formats that several rooms read or write."""


def test_only_formats_give_their_name_to_two_modules():
    names = Counter(name.rpartition("/")[2].removesuffix(".py") for name in modules())
    twice = {name for name, count in names.items() if count > 1 and name != "__init__"}
    assert twice == FORMATS


def public(tree):
    """Yield the public classes and functions of a module."""
    for node in tree.body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_"):
            if any(isinstance(d, ast.Name) and d.id == "overload" for d in node.decorator_list):
                continue  # a signature alone
            yield node
            if isinstance(node, ast.ClassDef):
                yield from public(node)


def test_everything_public_says_what_it_is():
    silent = [name for name, tree in modules().items() if not ast.get_docstring(tree)]
    silent += [
        f"{name}:{node.lineno} {node.name}"
        for name, tree in modules().items()
        for node in public(tree)
        if not ast.get_docstring(node)
    ]
    assert not silent


RIDDLE = re.compile(r"(One|What|It|Who|Whether|Which|Where|How|That|Those)\b")


def test_a_summary_begins_with_a_verb_or_a_noun_of_the_field():
    riddles = [
        f"{name}:{node.lineno} {node.value.value.splitlines()[0]}"
        for name, tree in modules().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
        and RIDDLE.match(node.value.value)
    ]
    assert not riddles


def test_only_the_command_line_prints():
    prints = [
        f"{name}:{node.lineno}"
        for name, tree in modules().items()
        if part(name) not in {"cli", "commands"} and not name.endswith("_worker.py")
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        if node.func.id == "print"
    ]
    assert not prints


def test_every_module_can_be_read_at_a_sitting():
    lines = {name: (PACKAGE / name).read_text("utf-8").count("\n") for name in modules()}
    assert not {name: count for name, count in lines.items() if count > 600}
