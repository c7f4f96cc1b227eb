"""The wall around the plug-ins: each name that they import from the rest is in one list.

The list leaves out what the packages of others may use: the public names, and those of a how-to.
"""

import ast
import re
from importlib import import_module

from places import ROOT, TESTS
from syntax_trees import modules
from test_house import imports, wing

EXTENDING = ROOT / "docs/how-to/extend-it.md"
STATED = re.compile(r"((?:`[\w.]+`(?:, )?)+) of `(lipsync_lang\.[\w.]+)`")

LIST = TESTS / "house" / "plugin_imports.txt"


def public():
    """Return the public names of the package, with the modules that define them."""
    stub = ast.parse((ROOT / "lipsync_lang" / "__init__.pyi").read_text("utf-8"))
    return {
        alias.name: f"lipsync_lang.{node.module}.{alias.name}"
        for node in stub.body
        for alias in node.names
    }


def extending():
    """Return the full names that the page of plug-ins tells their authors to use."""
    return {
        f"{module}.{name.partition('.')[0]}"
        for names, module in STATED.findall(EXTENDING.read_text("utf-8"))
        for name in re.findall(r"`([\w.]+)`", names)
    }


def imported():
    """Return the full names that the plug-ins import from the rest of the package."""
    return {
        name
        for path, tree in modules().items()
        if wing(path) == "plugins"
        for name in imports(tree)
        if name.startswith("lipsync_lang") and not name.startswith("lipsync_lang.plugins.")
    }


def test_public_names_are_imported_from_the_package_itself():
    found = imported()
    assert not found & set(public().values()), "import them from lipsync_lang"


def test_the_names_of_the_page_of_plug_ins_are_there():
    stated = extending()
    assert len(stated) > 50
    for name in sorted(stated):
        module, _, own = name.rpartition(".")
        assert hasattr(import_module(module), own), name


def test_the_list_has_exactly_the_names_that_plug_ins_import():
    stated = LIST.read_text("utf-8").splitlines()
    assert stated == sorted(set(stated))
    found = imported() - {f"lipsync_lang.{name}" for name in public()} - extending()
    assert not found - set(stated), "new: do without it, or add it to the list"
    if found:  # the wing can be removed
        assert not set(stated) - found, "no longer imported: remove it from the list"


def test_no_name_begins_with_an_underscore():
    stated = LIST.read_text("utf-8").splitlines()
    assert not [name for name in stated if any(part.startswith("_") for part in name.split("."))]
