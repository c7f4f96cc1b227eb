"""Bundle of ES modules in one script, for self-contained pages.

Each module becomes a function, so that names never clash. Only two forms are supported:
``import { a, b } from "./other.js";`` and ``export`` before a function, a class or a constant.
Comments in the form of JSDoc, which hold the types, stay in the source.
"""

import re
from importlib.resources import files

_IMPORT = re.compile(r'^import \{([\w\s,]+)\} from "\./(\w+)\.js";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|class|const) (\w+))", re.MULTILINE)
_COMMENT = re.compile(r"/\*\*.*?\*/[ \n]?", re.DOTALL)
_OTHER = re.compile(r"^\s*(?:import|export)\b|</script|<!--", re.MULTILINE)


def static(name: str) -> str:
    """Read a file of the folder `static`."""
    return (files("lipsync_lang.studio") / "static" / name).read_text("utf-8")


def bundle(entry: str) -> str:
    """Return a script with a module of `static` and all modules that it imports.

    Parameters
    ----------
    entry : name of the module, without its suffix

    Raises
    ------
    ValueError
        A module imports or exports in another form, or a name that is not exported, or modules
        import each other in a ring.
    """
    done: dict[str, str] = {}
    _collect(entry, done, ())
    body = "".join(f"const ${name} = (() => {{\n{text}\n}})();\n" for name, text in done.items())
    return f'"use strict";\n{body}'


def _collect(name: str, done: dict[str, str], path: tuple[str, ...]) -> None:
    """Add a module to `done`, after the modules that it imports."""
    if name in path:
        raise ValueError(f"modules import each other: {' -> '.join((*path, name))}")
    if name in done:
        return
    source = static(f"{name}.js")
    for names, other in _IMPORT.findall(source):
        _collect(other, done, (*path, name))
        missing = {one.strip() for one in names.split(",")} - {"", *_exported(other)}
        if missing:
            raise ValueError(f"{name}.js: {other}.js does not export {', '.join(sorted(missing))}")
    text = _COMMENT.sub("", _IMPORT.sub(r"const {\1} = $\2;\n", source))
    exported = _exported(name)
    text = _EXPORT.sub("", text)
    strange = _OTHER.search(text)
    if strange:
        raise ValueError(f"{name}.js: '{strange[0].strip()}' has a form that cannot be bundled")
    done[name] = f"{text}return {{ {', '.join(exported)} }};"


def _exported(name: str) -> list[str]:
    """Return the names that a module exports; of ``const a = 1, b = 2`` the first alone."""
    return _EXPORT.findall(_COMMENT.sub("", static(f"{name}.js")))
