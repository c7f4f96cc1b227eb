"""How much a command says beside its data: everything, the usual, or errors alone."""

import logging
import os
import sys
import warnings
from argparse import Namespace
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr
from typing import Any

from lipsync_lang.errors import LipsyncError
from lipsync_lang.extensions import PluginWarning

VARIABLE = "LIPSYNC_LANG_LOG"
"""The environment variable that shows the log: `debug` or `info`."""

LEVELS = {"debug": logging.DEBUG, "info": logging.INFO, "warning": logging.WARNING}


@contextmanager
def saying(options: Namespace) -> Iterator[None]:
    """Show the log where it is asked for, warnings of ours in a line, and nothing with --quiet.

    Errors are told by the caller, after this.
    """
    shown = "debug" if options.verbose else os.environ.get(VARIABLE, "")
    with ExitStack() as stack:
        if shown:
            stack.enter_context(_logged(shown))
        stack.enter_context(_warned())
        if options.quiet:
            nowhere = stack.enter_context(open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123
            stack.enter_context(redirect_stderr(nowhere))
        yield


@contextmanager
def _logged(name: str) -> Iterator[None]:
    if name.lower() not in LEVELS:
        raise LipsyncError(f"{VARIABLE}={name}: say {', '.join(LEVELS)}, or leave it out")
    ours = logging.getLogger("lipsync_lang")
    handler, before = logging.StreamHandler(sys.stderr), ours.level
    handler.setFormatter(logging.Formatter("%(name)s: %(message)s"))
    ours.addHandler(handler)
    ours.setLevel(LEVELS[name.lower()])
    try:
        yield
    finally:
        ours.removeHandler(handler)
        ours.setLevel(before)


@contextmanager
def _warned() -> Iterator[None]:
    """Print a plug-in's warnings without a line of code of ours; others look as usual."""
    usual = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *rest: Any, **more: Any) -> None:
        if issubclass(category, PluginWarning):
            print(message, file=sys.stderr)
        else:
            usual(message, category, *rest, **more)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = usual
