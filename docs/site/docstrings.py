"""Read the docstrings of this project: they describe a value, and the code has its type."""

import re
from typing import Any

from griffe import Extension, Object

UNDERLINE = re.compile(r"^(\w+)\n-{3,}\n", re.MULTILINE)


class StatedTypes(Extension):
    """Let the docstring describe parameters and results, whose types are their annotations."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """Rewrite the sections of a docstring to the form that the parser reads."""
        if obj.docstring:
            obj.docstring.value = rewritten(obj.docstring.value)


def rewritten(docstring: str) -> str:
    """Return a docstring with the descriptions of its sections on lines of their own."""
    head, *sections = UNDERLINE.split(docstring)
    parts = [head]
    for title, body in zip(sections[::2], sections[1::2], strict=True):
        change = CHANGES.get(title)
        parts.append(f"{title}\n{'-' * len(title)}\n{change(body) if change else body}")
    return "".join(parts)


def _parameters(body: str) -> str:
    return re.sub(r"^(\w[\w, *]*?) : (.+)$", r"\1\n    \2", body, flags=re.MULTILINE)


def _returns(body: str) -> str:
    """Mark a sentence as the description of the value, not as its type."""
    return ":\n" + "".join(f"    {line}\n" for line in body.rstrip().splitlines()) + "\n"


CHANGES = {"Parameters": _parameters, "Attributes": _parameters, "Returns": _returns}
