"""Bundle of ES modules in one script, for self-contained pages.

Each module becomes a function, so that names never clash; the names of the files are unique. Only
two forms are supported: ``import { a, b } from "../folder/other.js";`` and ``export`` before a
function, a class or a constant. Comments in the form of JSDoc, which hold the types, and the
indents stay in the source, so that less is sent.
"""

import posixpath
import re
from importlib.resources import files

_IMPORTS = re.compile(r'^import \{([\w\s,]+)\} from "(\.[./\w]+)\.js";\n', re.MULTILINE)
_EXPORTS = re.compile(r"^export (?=(?:async )?(?:function|class|const) (\w+))", re.MULTILINE)
_JSDOC = re.compile(r"/\*\*.*?\*/[ \n]?", re.DOTALL)
_INDENTS = re.compile(r"^ +", re.MULTILINE)
_UNSUPPORTED = re.compile(r"^\s*(?:import|export)\b|</script|<!--", re.MULTILINE)


def static(name: str) -> str:
    """Read a file of the folder `static`."""
    return (files("lipsync_lang.studio") / "static" / name).read_text("utf-8")


def bundle(entry: str) -> str:
    """Return a script with a module of `static`, named without its suffix, and all its imports.

    Raises ValueError if a module imports or exports in another form, or a name that is not
    exported, or modules import each other in a ring.
    """
    texts: dict[str, str] = {}
    _collect(entry, texts, ())
    body = "".join(
        f"const {_variable(path)} = (() => {{\n{text}\n}})();\n" for path, text in texts.items()
    )
    return f'"use strict";\n{body}'


def _collect(module: str, texts: dict[str, str], importers: tuple[str, ...]) -> None:
    """Add a module to `texts`, after the modules that it imports."""
    if module in importers:
        raise ValueError(f"modules import each other: {' -> '.join((*importers, module))}")
    if module in texts:
        return
    source = static(f"{module}.js")
    for names, where in _IMPORTS.findall(source):
        other = posixpath.normpath(posixpath.join(posixpath.dirname(module), where))
        _collect(other, texts, (*importers, module))
        missing = {name.strip() for name in names.split(",")} - {"", *_exported(other)}
        if missing:
            raise ValueError(
                f"{module}.js: {other}.js does not export {', '.join(sorted(missing))}"
            )
    text = _IMPORTS.sub(lambda found: f"const {{{found[1]}}} = {_variable(found[2])};\n", source)
    # Indents within template strings go as well; HTML and CSS do not need them.
    text = _INDENTS.sub("", _EXPORTS.sub("", _JSDOC.sub("", text)))
    strange = _UNSUPPORTED.search(text)
    if strange:
        raise ValueError(f"{module}.js: '{strange[0].strip()}' has a form that cannot be bundled")
    texts[module] = f"{text}return {{ {', '.join(_exported(module))} }};"


def _variable(path: str) -> str:
    """Return the name of the constant with the exports of a module, such as ``$take``."""
    return f"${posixpath.basename(path)}"


def _exported(module: str) -> list[str]:
    """Return the names that a module exports; of ``const a = 1, b = 2`` the first alone."""
    return _EXPORTS.findall(_JSDOC.sub("", static(f"{module}.js")))
