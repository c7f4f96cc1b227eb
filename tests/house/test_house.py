"""The house: a room imports only from floors below, and data stays out of code."""

import ast
import re
import runpy
import subprocess
import sys
from collections import defaultdict
from fnmatch import fnmatch
from functools import cache
from graphlib import CycleError, TopologicalSorter

import pytest
from lanes import full
from places import TESTS
from shipped import LIBRARY
from syntax_trees import PACKAGE, modules, walked

# Arrows

WINGS = (
    {"base"},
    {"pipeline", "schedules"},
    {"text"},
    {"packs"},
    {"faces"},
    {"animations", "resolver"},
    {"sound"},
    {"performing"},
    {"render", "reports"},
    {"production"},
    {"authoring"},
    {"studio"},
    {"commands"},
    {"plugins"},
    {"cli"},
)
"""The house from the ground up. A wing imports from the floors below it, never from its own."""

ROOMS = {
    "base": (
        {"arrays", "errors", "extras", "grouping", "json_object", "terminal", "version"},
        {"extensions", "files"},
        {"presentation"},
    ),
    "pipeline": ({"", "gestures"},),
    "text": ({"phonology"}, {"lines"}),
    "packs": ({"yaml"}, {"models"}, {""}, {"banks", "checking"}),
    "faces": ({"rigs"},),
    "sound": ({"speech"}, {"listening"}),
    "reports": ({"coverage", "quality"},),
    "production": ({"builds", "live"},),
    "plugins": (
        {"archives", "capture", "cluster", "heads", "players", "study"},
        {"programs", "scripts", "timings"},
        {"festival", "g2p", "htk", "mfa", "mouths", "phonemizer", "smartbody", "whisper"},
    ),
}
"""Floors of rooms within a wing, from the ground up; "" is the modules beside the rooms."""

ALONE = {
    "packs": {"base", "text"},
    "pipeline": {"base/arrays"},
    "pipeline/gestures": {"base/arrays"},
    "plugins/players": set(),
    "text/phonology": {"base"},
    "schedules": {"base"},
}
"""Rooms that import less than their floor allows."""

PLUG_INS = (PACKAGE / "plugins").is_dir()
"""False in a checkout from which the wing of plug-ins was removed."""

if not PLUG_INS:
    WINGS = tuple(floor for floor in WINGS if floor != {"plugins"})
    del ROOMS["plugins"]


def wing(room):
    """Return the wing of a room, or of a module's path."""
    return room.split("/")[0].removesuffix(".py")


def room(path):
    """Return the room of a module: its wing, and the room within it if the wing has floors."""
    first, second, *_ = (*path.split("/"), "")
    inner = second.removesuffix(".py")
    known = set().union(*ROOMS.get(wing(first), ()))
    return f"{first}/{inner}" if inner in known - {""} else wing(first)


def imports(tree):
    """Yield the full names of the package's modules that a module imports."""
    for node in walked(tree):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@cache
def arrows():
    """Return every import between rooms: the module, its room, and the room it imports from."""
    found = [
        (name, room(name), room(imported.partition(".")[2].replace(".", "/")))
        for name, tree in modules().items()
        for imported in imports(tree)
        if imported.startswith("lipsync_lang.")
    ]
    rooms = {room(name) for name in modules()}
    return [(name, here, there) for name, here, there in found if there in rooms - {here}]


def floors(numbered):
    """Map names to the number of their floor."""
    return {name: number for number, names in enumerate(numbered) for name in names}


def test_every_wing_and_room_has_a_floor():
    assert {wing(name) for name in modules()} - {"__init__", "__main__"} == set().union(*WINGS)
    for name, inside in ROOMS.items():
        parts = {path.partition("/")[2] for path in modules() if wing(path) == name}
        folders = {part.split("/")[0].removesuffix(".py") if part else "" for part in parts}
        loose = {part for part in parts if "/" not in part} - {"__init__.py"}
        rooms = set().union(*inside)
        missing = folders - {"__init__"} - rooms
        assert not missing or ("" in rooms and missing <= {n.removesuffix(".py") for n in loose})
        assert rooms - {""} <= folders


def test_arrows_between_wings_run_downwards_only():
    floor = floors(WINGS) | {"__init__": len(WINGS), "__main__": len(WINGS)}
    between = [(at, wing(here), wing(there)) for at, here, there in arrows()]
    upward = [one for one in between if one[1] != one[2] and floor[one[2]] >= floor[one[1]]]
    assert not upward


@pytest.mark.parametrize("name", ROOMS)
def test_arrows_within_a_wing_run_downwards_only(name):
    floor = floors(ROOMS[name])
    within = [one for one in arrows() if wing(one[1]) == wing(one[2]) == name]
    assert not [
        one for one in within if floor[one[2].partition("/")[2]] >= floor[one[1].partition("/")[2]]
    ]


@full
def test_the_picture_of_the_house_shows_these_arrows(root):
    drawn = runpy.run_path(str(root / "docs/draw_house.py"))
    wings = drawn["graph"](dict(drawn["sources"](None)))
    assert {(here, there) for here in wings for there in wings[here]} == {
        (wing(here), wing(there))
        for _, here, there in arrows()
        if wing(here) != wing(there) and not here.startswith("__")
    }
    assert drawn["matrix"](wings).endswith("in a ring: none")
    page = (root / "docs/explanation/house.md").read_text("utf-8")
    assert drawn["matrix"](wings) in page, "`python docs/draw_house.py` draws what the page shows"
    ring = {"one": {"other"}, "other": {"one"}}
    assert drawn["matrix"](ring).endswith("in a ring: one, other")


@pytest.mark.parametrize("name", ALONE)
def test_some_rooms_know_nearly_nothing(name):
    known = {to for _, here, to in arrows() if here == name and wing(to) != wing(name)}
    allowed = ALONE[name]
    assert not {there for there in known if not {there, wing(there)} & allowed}


RINGS = {"animations"}
"""Rooms with modules that import one another in a ring, if only for their types.

An animation saves and shows itself, so its module and its writers know each other.
"""


def test_modules_of_a_room_import_one_way():
    ringed = set()
    for one in {room(name) for name in modules()}:
        known = {
            ("lipsync_lang/" + name.removesuffix(".py")).replace("/", "."): tree
            for name, tree in modules().items()
            if room(name) == one
        }
        graph = {
            name: {one.rpartition(".")[0] for one in imports(tree)} & known.keys()
            for name, tree in known.items()
        }
        try:
            TopologicalSorter(graph).prepare()
        except CycleError:
            ringed.add(one)
    assert ringed == RINGS


WRITES_SCHEDULES = "animations/writers/performed_timings.py"
"""The only module of `animations` that may write schedules."""


def test_writers_know_only_the_schedule_itself():
    for name, tree in modules().items():
        if wing(name) == "animations" and name != WRITES_SCHEDULES:
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
    ("*_command.py", "english"): "the examples of --help can be typed as they stand",
    ("*_command.py", "facefx"): "the examples of --help can be typed as they stand",
    ("commands/*", "finnish"): "the examples of --help can be typed as they stand",
    ("*/azure.py", "azure"): "the program's format and its notation have one name",
    ("*/live2d.py", "live2d"): "the program's format and its pose set have one name",
    ("*/papagayo.py", "preston-blair"): "the notation that the format is in",
    ("*/polly.py", "polly"): "the program's format and its notation have one name",
    ("*/rhubarb.py", "rhubarb"): "the program's format and its notation have one name",
    ("*/cereproc.py", "cereproc"): "the program's format and its notation have one name",
    ("*/facefx.py", "facefx"): "the program's format and its pose set have one name",
    ("*/sapi.py", "sapi*"): "the program's format and its notation have one name",
    ("*/smartbody.py", "smartbody"): "the name of the format",
    ("plugins/timings/bml.py", "smartbody"): "the notation that the format is in",
    ("schedules/readers/json.py", "HH"): "the example of the format's form",
    ("packs/finding.py", "vrm"): "the suffix of files in the format",
    ("plugins/g2p/kana.py", "japanese"): "the name of the extra that installs it",
    ("text/phonology/g2p/pinyin.py", "mandarin"): "the name of the extra that installs it",
    ("plugins/g2p/*.py", "kana"): "the name of a respeller, after the script it writes",
    ("text/phonology/g2p/pinyin.py", "roman"): "a kind of script, within the module",
    ("text/phonology/labels.py", "*"): "letters of the IPA that are typed for one another",
    ("plugins/festival/festival_engine.py", "arpabet"): "the notation that its phone sets are in",
}
"""Reason for an exception by pattern of modules and names; obsolete entries must be removed."""


def texts(tree):
    """Yield the strings of a module without docstrings and format codes."""
    told = {id(n.value) for n in walked(tree) if isinstance(n, ast.Expr)}
    codes = {
        id(inner)
        for n in walked(tree)
        if isinstance(n, ast.FormattedValue) and n.format_spec
        for inner in ast.walk(n.format_spec)
    }
    for node in walked(tree):
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
    assert used == set(EXEMPT) or not PLUG_INS, "cured: remove it from EXEMPT"


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
    rooms = {room(name) for name in modules() if name.startswith(f"{room(name)}/")}
    # rooms of a wing with modules beside them may be tested in the folder of the wing
    beside = {one for one in rooms if "" in set().union(*ROOMS.get(wing(one), ()))}
    tested = {
        room(path.relative_to(TESTS).as_posix())
        for path in TESTS.rglob("test_*.py")
        if path.parent != TESTS
    }
    apart = {one for one in rooms - beside if "/" in one or one not in ROOMS}
    assert apart <= tested
    assert tested <= rooms | BESIDE.keys()
    assert not list(TESTS.glob("test_*.py")), "a test belongs into a folder"


@full
def test_every_module_of_tests_is_collected(root):
    command = [sys.executable, "-m", "pytest", "--collect-only", "-p", "no:cacheprovider"]
    told = subprocess.run(command, cwd=root, capture_output=True, encoding="utf-8", check=False)
    assert told.returncode == 0, told.stdout[-2000:]
    collected = {line.partition("::")[0] for line in told.stdout.splitlines() if "::" in line}
    assert collected == {p.relative_to(root).as_posix() for p in TESTS.rglob("test_*.py")}


# Habits


SHARED_NAMES = {
    *("ALONE", "BLOCK", "COMMANDS", "CONFIDENCE", "DECIMALS", "ENOUGH", "FORMS", "FREE"),
    *("HOLD_SECONDS", "MARK", "MAX_FINDINGS", "MAX_LINE_CHARS", "MAX_PLACES"),
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
        for node in walked(tree):
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
    cured = SHARED_NAMES - several.keys()
    assert not cured or not PLUG_INS, "cured: remove it from SHARED_NAMES"


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
        for node in walked(tree)
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
        if wing(name) not in {"cli", "commands"}
        and not name.endswith(("_command.py", "_worker.py"))
        for node in walked(tree)
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
