"""Rails' YAML: a tree of texts below the tag of each language."""

from collections.abc import Iterator
from typing import Any

from lipsync_lang.text.lines.columns import language_column
from lipsync_lang.text.lines.entries import MAX_ENTRY_DEPTH, ScriptEntry, entry_lines, whole_file
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

MAX_TREE_TEXTS = 200_000
"""Maximum number of texts; aliases within aliases would make more of a small file."""


@reader("rails", suffixes=[".yml"])
def read(source: LineFile) -> Iterator[Line]:
    """Rails' .yml: the texts below the tag of the language; the keys name a line."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError
    from ruamel.yaml.nodes import MappingNode

    try:
        # Nodes keep their lines, which loaded data would lose.
        root = YAML(typ="safe", pure=True).compose(whole_file(source).text)
    except (YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        what = getattr(error, "problem", None) or str(error).split("\n", 1)[0]
        line = mark.line + 1 if mark else 1
        raise source.fault(line, f"not YAML: {what}; correct the file") from None
    if not isinstance(root, MappingNode) or not root.value:
        raise source.fault(1, "has no language; begin with its tag, such as `de:`")
    names = [str(key.value) for key, _ in root.value]
    at = language_column(names, source.names)
    chosen = [root.value[at]] if at >= 0 else root.value
    found = (
        one
        for key, node in chosen
        for one in _texts(source, node, () if len(chosen) == 1 else (str(key.value),))
    )
    return entry_lines(source, _counted(source, found))


def _texts(source: LineFile, node: Any, keys: tuple[str, ...]) -> Iterator[ScriptEntry]:
    """Yield the texts at and below a node."""
    line = node.start_mark.line + 1
    if len(keys) > MAX_ENTRY_DEPTH:
        what = f"is nested deeper than {MAX_ENTRY_DEPTH} levels; check what wrote it"
        raise source.fault(line, what)
    if node.id == "scalar":
        # Numbers, dates and switches, such as formats of currencies, are not spoken.
        if node.tag.endswith(":str"):
            yield ScriptEntry(line, ".".join(keys), node.value)
        return
    pairs = node.value if node.id == "mapping" else enumerate(node.value)
    for key, inner in pairs:
        name = str(key) if isinstance(key, int) else str(key.value)
        yield from _texts(source, inner, (*keys, name))


def _counted(source: LineFile, found: Iterator[ScriptEntry]) -> Iterator[ScriptEntry]:
    for number, one in enumerate(found):
        if number == MAX_TREE_TEXTS:
            raise source.fault(one.number, f"has more than {MAX_TREE_TEXTS:,} texts; split it")
        yield one
