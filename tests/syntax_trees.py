"""Syntax trees of the package, which tests of its source share: to parse it takes seconds."""

import ast
from functools import cache
from pathlib import Path

import lipsync_lang as ll

PACKAGE = Path(ll.__file__).parent


@cache
def modules():
    """Return the syntax tree of every module, by its path."""
    paths = sorted(PACKAGE.rglob("*.py"))
    assert paths, "a sweep over nothing passes"
    return {path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_bytes()) for path in paths}


@cache
def walked(tree):
    """Return all nodes of a module's tree; a walk takes longer than a test of its nodes."""
    return tuple(ast.walk(tree))
