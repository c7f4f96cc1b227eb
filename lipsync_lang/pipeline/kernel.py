"""The compiled kernel, `kernel.c`, where it was built; loading it needs no numpy.

`kernel_plan` passes performances to it. The stages in numpy are its specification, and they run
wherever it is absent, switched off, or does not serve the settings.
"""

import os
from importlib import import_module
from typing import Any

SWITCH = "LIPSYNC_LANG_KERNEL"
"""Environment variable: `off` leaves the compiled kernel out."""


INTERFACE = 2
"""Number of the calls and arguments; a library of another number was built from older code."""


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
    """Return which of the two runs, for `--version`."""
    if compiled is not None:
        return "compiled kernel"
    return f"numpy; {SWITCH} is off" if _off() else "numpy; no compiled kernel"


def _off() -> bool:
    return os.environ.get(SWITCH, "").strip().lower() == "off"


compiled = load()
