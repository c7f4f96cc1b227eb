"""The house: a room imports only from floors below, and data stays out of code."""

import ast
import re
import runpy
from collections import defaultdict
from fnmatch import fnmatch
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from lanes import full
from places import TESTS
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
    {"arrays", "json_object", "errors", "extras", "version", "terminal"},
    {"extensions", "files"},
    {"gestures", "phonology", "pipeline", "reports", "schedules"},
    {"lines", "packs"},
    {"banks", "rigs"},
    {"animations", "resolver"},
    {"speech"},
    {"listening"},
    {"performing"},
    {"coverage", "heads", "live", "quality", "render"},
    {"authoring"},
    {"build"},
    {"studio"},
    {"commands"},
    {"capture", "cluster", "mfa", "players", "smartbody", "study"},
    {"cli"},
)
"""The house from the ground up. A room imports from the floors below it, never from its own."""

PACKS = ("yaml", "models", "", "checking")
"""Floors within `packs`; modules without a folder are between the models and the checks."""

ALONE = {
    "gestures": {"arrays"},
    "pipeline": {"arrays"},
    "players": {"commands", "errors", "files"},
    "phonology": {"arrays", "errors", "extensions", "extras", "files", "json_object"},
    "schedules": {"arrays", "errors", "extensions", "files", "json_object"},
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


RINGS = {
    "animations", "build", "commands", "coverage", "lines", "packs", "performing", "phonology",
}  # fmt: skip
"""Rooms with modules that import one another in a ring, if only for their types."""


def test_modules_of_a_room_import_one_way():
    ringed = set()
    for room in set().union(*FLOORS):
        known = {
            ("lipsync_lang/" + name.removesuffix(".py")).replace("/", "."): tree
            for name, tree in modules().items()
            if part(name) == room
        }
        graph = {
            name: {one.rpartition(".")[0] for one in imports(tree)} & known.keys()
            for name, tree in known.items()
        }
        try:
            TopologicalSorter(graph).prepare()
        except CycleError:
            ringed.add(room)
    assert ringed == RINGS


WRITES_SCHEDULES = "animations/writers/performed_timings.py"
"""The only module of `animations` that may write schedules."""


def test_writers_know_only_the_schedule_itself():
    for name, tree in modules().items():
        if part(name) == "animations" and name != WRITES_SCHEDULES:
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
    """Return every name that belongs in packs, with its kind.

    Tags of languages are left out: `is`, `id` and `my` are words of programs too, and the names
    of languages find the same code.
    """
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
        found[model.name] = "language"
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
    "letters": "what words are made of",
    "label": "what phonemes are called by",
    "ipa": "the alphabet, a file of its own, and what other programs call it",
    "NG": "eSpeak NG is an engine",
}
"""Names of packs that are ordinary words of programs."""

EXEMPT = {
    ("commands/*", "english"): "the examples of --help can be typed as they stand",
    ("commands/*", "facefx"): "the examples of --help can be typed as they stand",
    ("*/*_command.py", "english"): "the examples of --help can be typed as they stand",
    ("*/*_command.py", "facefx"): "the examples of --help can be typed as they stand",
    ("commands/*", "finnish"): "the examples of --help can be typed as they stand",
    ("*/azure.py", "azure"): "the program's format and its notation have one name",
    ("*/live2d.py", "live2d"): "the program's format and its pose set have one name",
    ("*/vrma.py", "vrm"): "the file with the names of the format's expressions",
    ("commands/*", "vrm"): "the suffix of files in the format",
    ("*/papagayo.py", "preston-blair"): "the notation that the format is in",
    ("*/polly.py", "polly"): "the program's format and its notation have one name",
    ("*/rhubarb.py", "rhubarb"): "the program's format and its notation have one name",
    ("*/sapi.py", "sapi*"): "the program's format and its notation have one name",
    ("*/smartbody.py", "smartbody"): "the name of the format",
    ("schedules/readers/bml.py", "smartbody"): "the notation that the format is in",
    ("schedules/readers/json.py", "HH"): "the example of the format's form",
    ("packs/finding.py", "vrm"): "the suffix of files in the format",
    ("phonology/g2p/kana.py", "japanese"): "the name of the extra that installs it",
    ("phonology/g2p/pinyin.py", "mandarin"): "the name of the extra that installs it",
    ("phonology/g2p/*.py", "kana"): "the name of a respeller, after the script it writes",
    ("phonology/g2p/pinyin.py", "roman"): "a kind of script, within the module",
    ("phonology/labels.py", "*"): "letters of the IPA that are typed for one another",
    ("speech/speaking/festival.py", "arpabet"): "the notation that its phone sets are in",
}
"""Reason for an exception by pattern of modules and names; obsolete entries must be removed."""


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
        if len(word) > 1 and (what in TOLD_APART or unmistaken):
            yield word


def test_no_module_knows_the_name_of_a_language_a_phoneme_or_a_pose():
    found = {
        (name, word)
        for name, tree in modules().items()
        for text in texts(tree)
        for word in named(text)
        if word not in ORDINARY
    }
    excuses = {
        one: [row for row in EXEMPT if fnmatch(one[0], row[0]) and fnmatch(one[1], row[1])]
        for one in found
    }
    loose = sorted(one for one, rows in excuses.items() if not rows)
    assert not loose, "names that belong into packs"
    used = {row for rows in excuses.values() for row in rows}
    assert used == set(EXEMPT), "cured: remove it from EXEMPT"


# Tests as a map

BESIDE = {
    "house": "rules of the whole package, and its wheel",
    "docs": "pages, docstrings and prose",
    "browser": "pages in a browser",
    "fuzz": "damaged files for every reader",
    "prose": "the linter of prose",
    "consumers": "scripts for other programs",
}
"""Folders of tests that stand for no room."""


def test_every_room_has_a_folder_of_tests():
    rooms = {part(name) for name in modules() if "/" in name}
    folders = {
        path.name for path in TESTS.iterdir() if path.is_dir() and not path.name.startswith("_")
    }
    assert folders == rooms | BESIDE.keys()
    assert not list(TESTS.glob("test_*.py")), "a test belongs into a folder"


# Habits


SHARED_NAMES = {
    *("ALONE", "BLOCK", "COMMANDS", "CONFIDENCE", "DECIMALS", "ENOUGH", "FORMS", "FREE"),
    *("HOLD_SECONDS", "MARK", "MAX_FINDINGS", "MAX_LINE_CHARS", "MAX_NAMES", "MAX_PLACES"),
    *("MAX_SHOWN_CHARS", "MAX_SLUG_CHARS", "MAX_TABLE_ROWS", "MAX_VALUE_CHARS", "MOST", "NAME"),
    *("NAME_COLUMNS", "PACK_NAME", "PROGRAM", "SHOWN", "SUFFIXES", "TIMES"),
    *("TITLE", "UNKNOWN", "USUAL"),
}
"""Constants that still have several meanings; a name that gets one meaning must be removed."""


def meanings():
    """Yield the names that modules define, without underscores, with their meanings and places.

    Two classes of one name have two meanings, and so have two aliases or constants that differ.
    """
    for name, tree in modules().items():
        for node in ast.walk(tree):
            place = f"{name}:{getattr(node, 'lineno', 0)}"
            if isinstance(node, ast.ClassDef):
                yield node.name.lstrip("_"), place, place
            elif isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                for target in targets:
                    if isinstance(target, ast.Name) and re.match(r"_*[A-Z]\w+$", target.id):
                        yield target.id.lstrip("_"), ast.unparse(node.value), place


def test_one_name_has_one_meaning():
    found = defaultdict(lambda: defaultdict(list))
    for name, meaning, place in meanings():
        found[name][meaning].append(place)
    several = {name: [*found[name].values()] for name in found if len(found[name]) > 1}
    assert not {name: places for name, places in several.items() if name not in SHARED_NAMES}
    assert several.keys() == SHARED_NAMES, "cured: remove it from SHARED_NAMES"


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
        if part(name) not in {"cli", "commands"}
        and not name.endswith(("_command.py", "_worker.py"))
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        if node.func.id == "print"
    ]
    assert not prints


def test_every_module_can_be_read_at_a_sitting():
    lines = {name: (PACKAGE / name).read_text("utf-8").count("\n") for name in modules()}
    assert not {name: count for name, count in lines.items() if count > 600}


def test_no_script_of_the_browser_waits_for_a_clock_or_for_nothing():
    scripts = {path.name: path.read_text("utf-8") for path in TESTS.glob("browser/*.mjs")}
    # `waitForFunction` takes the promise of an async condition for "true", and returns at once
    waits = re.compile(r"waitForTimeout|setTimeout|waitForFunction\(async")
    assert scripts
    assert not [name for name, script in scripts.items() if waits.search(script)]
