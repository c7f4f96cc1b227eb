"""Command-line entry point: dispatch, exit codes and error reporting.

Data goes to stdout, messages to stderr. Exit codes: 0 success; 1 faults found; 2 misuse; 130 and
143 for interruption and termination, as in shells.
"""

import logging
import os
import sys
import warnings
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, redirect_stderr, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import Any

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.extensions import PluginWarning, plug_in_behind
from lipsync_lang.base.files.signals import Terminated, terminating
from lipsync_lang.base.files.targets import read_only
from lipsync_lang.base.terminal import safe_streams
from lipsync_lang.commands.defaults import fill
from lipsync_lang.commands.output import FAULTS, INTERRUPTED, MISUSE, SOUND, as_options
from lipsync_lang.commands.parser import parser
from lipsync_lang.commands.registry import COMMANDS, Handler

LOG_VARIABLE = "LIPSYNC_LANG_LOG"
"""Environment variable for the log level: `debug` or `info`."""

LOG_LEVELS = {"debug": logging.DEBUG, "info": logging.INFO, "warning": logging.WARNING}

_log = logging.getLogger(__name__)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    _encode_all()
    try:
        with terminating(), safe_streams():
            return _worded(arguments)
    except BrokenPipeError:  # the reader closed the pipe early
        _discard_output()
        return SOUND
    except KeyboardInterrupt:
        return INTERRUPTED
    except Terminated as ended:
        return ended.code


def _worded(arguments: Sequence[str] | None) -> int:
    """Run one command and report errors as messages on stderr."""
    try:
        return _run(arguments)
    except BrokenPipeError:
        raise
    except LipsyncError as error:
        of_packs = hasattr(error, "faults")  # pack errors quote file fields, not arguments
        told = str(error) if of_packs else as_options(str(error))
        print(f"lipsync-lang: {told}", file=sys.stderr)
        return FAULTS if of_packs else MISUSE
    except OSError as error:
        _discard_output()
        # `os.getcwd` names no file in its error.
        if isinstance(error, FileNotFoundError) and error.filename is None:
            told = "the current folder no longer exists; change to another"
        else:
            where = f"{error.filename}: " if error.filename else ""
            path = Path(error.filename or "")
            locked = "" if os.path.exists(path) else read_only(path, error)  # noqa: PTH110 no error
            told = f"{where}{locked or error.strerror or error}"
        print(f"lipsync-lang: {told}", file=sys.stderr)
        return MISUSE
    except MemoryError:
        print("lipsync-lang: out of memory; use fewer --fps or a shorter line", file=sys.stderr)
        return MISUSE
    except Exception as error:
        plug_in = plug_in_behind(error)
        if plug_in is None:
            raise  # a fault of this program: its traceback belongs in the report
        _log.debug("%s failed", plug_in, exc_info=True)
        print(
            f"lipsync-lang: the plug-in {plug_in} failed: {type(error).__name__}: {error}; "
            "report it to its authors with the output of `-v`",
            file=sys.stderr,
        )
        return MISUSE


def _run(arguments: Sequence[str] | None) -> int:
    try:
        given = sys.argv[1:] if arguments is None else list(arguments)
        if given[:1] == ["help"]:
            given = [*given[1:], "--help"]
        first = next(iter(given), None)
        made = parser(first)
        if first and first[0] != "-" and first not in COMMANDS.modules and first not in COMMANDS:
            known = [name for name in COMMANDS if " " not in name]
            made.error(f"unknown command '{first}': {did_you_mean(first, known)}")
        options = made.parse_args(given)
        command: Handler = options.command
        with saying(options):
            fill(options)
            return command(options)
    finally:
        # Here, where a pipe that was closed is still an error with an answer.
        if sys.stdout is not None:
            sys.stdout.flush()


@contextmanager
def saying(options: Namespace) -> Iterator[None]:
    """Configure the log, one-line warnings and --quiet while a command runs.

    Errors are reported by the caller, after this context has closed.
    """
    shown = "debug" if options.verbose else os.environ.get(LOG_VARIABLE, "")
    if shown and shown.lower() not in LOG_LEVELS:
        known = ", ".join(LOG_LEVELS)
        raise LipsyncError(f"{LOG_VARIABLE}={shown}: set it to one of {known}, or unset it")
    usual = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *rest: Any, **more: Any) -> None:
        if issubclass(category, PluginWarning):
            print(message, file=sys.stderr)  # without a source line
        else:
            usual(message, category, *rest, **more)

    with ExitStack() as stack:
        if shown:
            ours = logging.getLogger("lipsync_lang")
            handler = logging.StreamHandler(sys.stderr)
            handler.setFormatter(logging.Formatter("%(name)s: %(message)s"))
            stack.callback(ours.setLevel, ours.level)
            stack.callback(ours.removeHandler, handler)
            ours.addHandler(handler)
            ours.setLevel(LOG_LEVELS[shown.lower()])
        stack.callback(setattr, warnings, "showwarning", usual)
        warnings.showwarning = show
        if options.quiet:
            nowhere = stack.enter_context(open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123
            stack.enter_context(redirect_stderr(nowhere))
        yield


def _encode_all() -> None:
    """Escape characters outside the terminal's encoding; pipes and files carry UTF-8 on Windows.

    Python would use the code page, which other programs do not expect, and which lacks the IPA.
    """
    stated = sys.platform != "win32" or "PYTHONIOENCODING" in os.environ
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            if not stated and not stream.isatty():
                stream.reconfigure(encoding="utf-8")
            if stream is not sys.stdin:
                stream.reconfigure(errors="backslashreplace")


def _discard_output() -> None:
    """Redirect stdout to the null device so that Python's final flush cannot fail."""
    if sys.stdout is not None:
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
