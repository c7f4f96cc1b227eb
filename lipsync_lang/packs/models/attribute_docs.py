"""Descriptions of fields: the docstrings beneath them, read when a schema or a message needs one.

Pydantic can take them while it makes a class, but then parses the source of each class at every
start of the program, which takes longer than reading the packs.
"""

import ast
import sys
from functools import cache
from inspect import cleandoc, getsource
from itertools import pairwise
from typing import Any

from pydantic import BaseModel


def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Return what describes each field of a model, by the field's name in the class.

    A description that the field itself states goes before the docstring beneath it. A program
    without its source files has no docstrings to read.
    """
    found: dict[str, str] = {}
    for kind in reversed(model.__mro__):
        # base classes of pydantic have docstrings of their own
        if kind.__module__.startswith(__package__):
            found |= _docstrings(kind.__module__).get(kind.__name__, {})
    fields = model.model_fields.items()
    stated = {name: field.description or found.get(name, "") for name, field in fields}
    return {name: text for name, text in stated.items() if text}


def describe(schema: dict[str, Any], model: type[BaseModel]) -> None:
    """Add the descriptions of a model's fields to its JSON Schema."""
    texts = descriptions(model)
    for name, field in model.model_fields.items():
        made = schema.get("properties", {}).get(field.alias or name)
        if made is not None and name in texts:
            made["description"] = texts[name]


@cache
def _docstrings(module: str) -> dict[str, dict[str, str]]:
    """Read the attribute docstrings of a module, by class and attribute."""
    try:
        tree = ast.parse(getsource(sys.modules[module]))
    except OSError:
        return {}
    return {
        node.name: {
            stated.target.id: cleandoc(text.value.value)
            for stated, text in pairwise(node.body)
            if isinstance(stated, ast.AnnAssign)
            and isinstance(stated.target, ast.Name)
            and isinstance(text, ast.Expr)
            and isinstance(text.value, ast.Constant)
            and isinstance(text.value.value, str)
        }
        for node in tree.body
        if isinstance(node, ast.ClassDef)
    }
