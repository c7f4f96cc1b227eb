"""Print which wings of `lipsync_lang` import from which, for `docs/explanation/house.md`.

    python docs/draw_house.py [REVISION]

A wing is a folder or a loose module. Its row marks the wings it imports from, lazy imports
included. Wings stand above those they import from, as far as that is possible: an `x` left of the
diagonal is an import upwards, or within a ring of wings that import from each other.
"""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "lipsync_lang"

Graph = dict[str, set[str]]
"""For each wing, the wings it imports from."""


def sources(revision: str | None) -> Iterator[tuple[str, str]]:
    """Yield the path within the package and the text of every module."""
    if revision is None:
        for path in sorted((ROOT / PACKAGE).rglob("*.py")):
            yield path.relative_to(ROOT / PACKAGE).as_posix(), path.read_text("utf-8")
        return

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(ROOT), *arguments]
        return subprocess.run(command, check=True, capture_output=True, encoding="utf-8").stdout  # noqa: S603 git

    for name in git("ls-tree", "-r", "--name-only", revision, PACKAGE).splitlines():
        if name.endswith(".py"):
            yield name.removeprefix(f"{PACKAGE}/"), git("show", f"{revision}:{name}")


def wing(name: str) -> str:
    """Return the wing of a module, named by its path within the package."""
    return name.split("/", maxsplit=1)[0].removesuffix(".py")


def graph(modules: dict[str, str]) -> Graph:
    """Return the wings with what each imports from; the package's own module is none."""
    found: Graph = {wing(name): set() for name in modules if not name.startswith("__")}
    for name, text in modules.items():
        for node in ast.walk(ast.parse(text)) if wing(name) in found else ():
            names = [alias.name for alias in getattr(node, "names", ()) if hasattr(alias, "name")]
            if isinstance(node, ast.ImportFrom):
                names = [f"{node.module}.{name}" for name in names]
            elif not isinstance(node, ast.Import):
                continue
            steps = (name.split(".") for name in names)
            there = {s[1] for s in steps if s[0] == PACKAGE and len(s) > 1}
            found[wing(name)] |= there & found.keys() - {wing(name)}
    return found


def below(wings: Graph, start: str) -> set[str]:
    """Return the wings that a wing imports from, directly or through others."""
    seen: set[str] = set()
    ahead = [start]
    while ahead:
        new = wings[ahead.pop()] - seen
        seen |= new
        ahead += new
    return seen


def ordered(wings: Graph) -> list[str]:
    """Order wings from the roof to the ground: those that need most of the others come first."""
    return sorted(wings, key=lambda name: (-len(below(wings, name)), -len(wings[name]), name))


def matrix(wings: Graph) -> str:
    """Return the graph as a square of rows and columns, from the roof to the ground."""
    order = ordered(wings)
    width = max(map(len, order))
    lines = [" " * (width + 4) + " ".join(f"{n % 100:>2}" for n in range(1, len(order) + 1))]
    for number, name in enumerate(order, start=1):
        cells = ("-" if other == name else "x" if other in wings[name] else "." for other in order)
        lines.append(f"{number:>2} {name:<{width}} " + " ".join(f"{cell:>2}" for cell in cells))
    ring = [name for name in order if name in below(wings, name)]
    lines += ["", f"in a ring: {', '.join(ring) or 'none'}"]
    return "\n".join(lines)


if __name__ == "__main__":
    asked = sys.argv[1] if sys.argv[1:] else None
    sys.stdout.write(f"{matrix(graph(dict(sources(asked))))}\n")
