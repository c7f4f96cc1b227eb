"""Argument parser: every command with its arguments and an example."""

import argparse

from lipsync_lang.commands import listing
from lipsync_lang.commands.bank_options import add_bank
from lipsync_lang.commands.build_options import add_build
from lipsync_lang.commands.completion import SHELLS, completion, leaves
from lipsync_lang.commands.coverage_options import add_coverage
from lipsync_lang.commands.live_options import add_live, add_studio
from lipsync_lang.commands.pack_options import add_checking, add_packs
from lipsync_lang.commands.performing_options import (
    add_check,
    add_explain,
    add_run,
    add_stills,
    add_transcribe,
)
from lipsync_lang.commands.shared_options import Add, add_json, add_words, adder
from lipsync_lang.commands.starting import welcome
from lipsync_lang.commands.starting_options import add_doctor, add_new
from lipsync_lang.commands.study_options import add_study
from lipsync_lang.pipeline import kernel
from lipsync_lang.version import __version__


def parser() -> argparse.ArgumentParser:
    """Build the parser; `docs/reference/commands.md` is generated from it."""
    top = argparse.ArgumentParser(
        prog="lipsync-lang",
        description="Lip sync for any language and any character, from data you can edit.",
        epilog='Try: lipsync-lang run "Hello, world" -l english -c facefx -o hello.csv',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.color = False  # type: ignore[attr-defined] # Python 3.14 would colour what is spelled out
    version = f"lipsync-lang {__version__} ({kernel.summary()})"
    top.add_argument("--version", action="version", version=version)
    top.set_defaults(command=welcome, quiet=False, verbose=False)
    known = top.add_subparsers(title="commands", metavar="COMMAND", required=False)

    add = adder(known)
    add_new(add)
    add_doctor(add)
    add_run(add)
    add_transcribe(add)
    add_explain(add)
    add_stills(add)
    add_live(add)
    add_studio(add)
    add_checking(add)
    add_coverage(add)
    add_check(add)
    add_build(add)
    add_packs(add)
    add_bank(add)
    add_study(add)
    _add_lists(add)
    for _, made in leaves(top):
        add_words(made)
    return top


def _add_lists(add: Add) -> None:
    """Add `voices`, `formats` and `completion`."""
    voices_ = add("voices", listing.voices, "list the voices that speak text", "voices")
    voices_.add_argument(
        "engine", metavar="ENGINE", nargs="?", default="espeak", help="a speech engine [espeak]"
    )
    add_json(voices_)
    formats_ = add(
        "formats", listing.formats, "list the formats that can be read and written", "formats"
    )
    add_json(formats_)
    completion_ = add(
        "completion",
        completion,
        "print a script that completes commands, options and names in a shell",
        "completion bash > ~/.local/share/bash-completion/completions/lipsync-lang",
    )
    completion_.add_argument("shell", choices=SHELLS, help="the shell")
