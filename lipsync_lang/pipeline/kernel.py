"""The compiled kernel, `kernel.c`, if it was built; loading it does not need numpy.

`kernel_plan` passes performances to it, and `render.model` pictures. The code in numpy is its
specification, and it runs wherever the kernel is absent, switched off, or does not serve the
settings.
"""

import os
from importlib import import_module
from typing import Any

SWITCH = "LIPSYNC_LANG_KERNEL"
"""Environment variable; `off` disables the compiled kernel."""

INTERFACE = 10
"""Version of the calls and arguments; a library with another version is from other code."""


def load() -> Any:
    """Return the compiled module; None if it is missing for this code, or `SWITCH` is off."""
    if _off():
        return None
    try:
        module = import_module("lipsync_lang.pipeline._kernel")
    except ImportError:
        return None
    return module if module.INTERFACE == INTERFACE else None


def summary() -> str:
    """Return the name of the implementation in use, for `--version`."""
    if compiled is not None:
        return "compiled kernel"
    return f"numpy; {SWITCH} is off" if _off() else "numpy; no compiled kernel"


def _off() -> bool:
    return os.environ.get(SWITCH, "").strip().lower() == "off"


compiled = load()
