"""Verbosity of messages beside a command's data: debug, normal or errors only."""

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
"""Environment variable for the log level: `debug` or `info`."""

LEVELS = {"debug": logging.DEBUG, "info": logging.INFO, "warning": logging.WARNING}


@contextmanager
def saying(options: Namespace) -> Iterator[None]:
    """Configure the log, one-line warnings and --quiet while a command runs.

    Errors are reported by the caller, after this context has closed.
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
        raise LipsyncError(f"{VARIABLE}={name}: set it to one of {', '.join(LEVELS)}, or unset it")
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
    """Print plug-in warnings without a source line; others keep Python's format."""
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
