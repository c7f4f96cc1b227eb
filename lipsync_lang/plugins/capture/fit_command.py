"""The command that fits a character to captures."""

import os
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from lipsync_lang import LipsyncError
from lipsync_lang.base.errors import count
from lipsync_lang.base.files import STANDARD_STREAM, argument_path, write_all
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.base.terminal import progress
from lipsync_lang.commands.output import FAULTS, SOUND, as_json, tell_written, working
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_options, option

if TYPE_CHECKING:
    from lipsync_lang.plugins.capture.fit_captures import CaptureFit
    from lipsync_lang.plugins.capture.fit_file import FitProposal


SHOWN = 12
"""Maximum number of items and lines to print."""


@command("bank fit")
def _add_fit(action: Add) -> None:
    made = action(
        fit,
        "fit targets, motion and bigrams to captures of a face",
        "bank fit captures/ -l english -c facefx -o fit.json",
        more=", and test them on held-out lines",
    )
    made.add_argument(
        "captures", metavar="CAPTURE", type=Path, nargs="+",
        help="a capture, a list of captures, or a folder to search; each capture needs timings, or "
        "text and sound, beside it",
    )  # fmt: skip
    add_options(made, ["pair"])
    option(
        made, "--readout FILE",
        "the measures that a table of sensors shows [readout.yaml of its folder]", type=Path,
    )  # fmt: skip
    option(
        made, "--speaker PATTERN",
        "the place of the speaker in file names, such as '{speaker}_*' [the first folder]",
    )  # fmt: skip
    option(made, "--notation NAME", "the notation of the timings' labels")
    option(
        made, "--aligner NAME[:MODEL]",
        "another aligner than the language's, for captures with text and sound",
    )  # fmt: skip
    option(
        made, "-o, --output FILE", "write the proposal, for `bank accept`; - is standard output",
        type=argument_path,
    )  # fmt: skip
    option(
        made, "--page FILE",
        "write an HTML page of captures beside curves, and of all values found", type=argument_path,
    )  # fmt: skip
    option(made, "--workers N", "number of processes [one per core]", type=int)
    add_options(made, ["json"])


def fit(options: Namespace) -> int:
    """Fit a pair to captures; print the result, and write proposal and page."""
    from lipsync_lang.plugins.capture.fit_file import write_fit
    from lipsync_lang.plugins.capture.fit_page import fit_page

    if options.page is not None and options.page == options.output:
        raise LipsyncError(f"{options.page}: the proposal and the page need different files")
    found = _fitted(options)
    proposal = found.proposal
    writers = {}
    if options.output is not None:
        text = StringIO()
        write_fit(text, proposal)
        writers[options.output] = _writer(text.getvalue())
    if options.page is not None:
        writers[options.page] = _writer(fit_page(found.shown, proposal))
    write_all(writers)
    words = sys.stderr if STANDARD_STREAM in writers else sys.stdout
    if options.json:
        print(as_json(proposal.model_dump(mode="json")), file=words)
    else:
        print("\n".join(proposal_lines(proposal)), file=words)
    for path in writers:
        tell_written(path)
    if not proposal.verdict.accepted:
        return FAULTS
    if options.output is not None and options.output != STANDARD_STREAM:
        print(f"accept values with: lipsync-lang bank accept {options.output}", file=sys.stderr)
    return SOUND


def _writer(text: str) -> Callable[[BinaryIO], object]:
    return lambda stream: stream.write(text.encode())


def _fitted(options: Namespace) -> "CaptureFit":
    from lipsync_lang import Performer
    from lipsync_lang.packs.library import Library
    from lipsync_lang.plugins.capture.capture_reading import read_captures
    from lipsync_lang.plugins.capture.fit_captures import fit_captures
    from lipsync_lang.plugins.capture.judging import judge_captures
    from lipsync_lang.resolver.retouch import OpenPair

    if options.workers is not None and options.workers < 1:
        raise LipsyncError(f"{options.workers} workers: give 1 or more")
    pair = OpenPair.open(Library(options.path), options.language, options.character)
    performer = Performer(pair.compiled, pair.compiled.motion, paths=tuple(options.path))
    with working("reading captures"):
        captures = read_captures(
            performer,
            options.captures,
            readout=options.readout,
            speaker=options.speaker,
            aligner=options.aligner,
            notation=options.notation,
            progress=lambda done, total: progress(f"reading {done} of {total} captures ..."),
        )
        captures = judge_captures(
            performer,
            captures,
            progress=lambda done, total: progress(f"judging {done} of {total} captures ..."),
        )
        return fit_captures(
            pair,
            performer,
            captures.lines,
            workers=options.workers or os.cpu_count() or 1,
            progress=lambda text: progress(f"{text} ..."),
            set_aside=captures.set_aside,
        )


def proposal_lines(proposal: "FitProposal") -> Iterator[str]:
    """Yield the printed lines of a proposal."""
    who = f"{proposal.language} on {proposal.character}"
    yield f"{who}: {count(proposal.lines, 'line')}, {proposal.seconds:.1f} s of capture"
    for one in proposal.set_aside:
        yield f"  set aside {one.line}: {one.why}"
    for remark in proposal.remarks:
        yield f"  {remark}"
    yield f"{'accepted' if proposal.verdict.accepted else 'REFUSED'}: {proposal.verdict.why}"
    folds = [
        (f"  without {one.by} {one.held_out}", f"{one.before:.4f}", f"{one.after:.4f}")
        for one in proposal.verdict.folds
    ]
    yield from columns([("  held out", "before", "after"), *folds])
    items = sorted(proposal.items, key=lambda one: -one.confidence * one.occurrences)
    rows = [
        (
            f"  {one.item}",
            str(one.occurrences),
            _number(one.residual_before),
            _number(one.residual_after),
            f"{one.confidence:.2f}",
        )
        for one in items[:SHOWN]
    ]
    if rows:
        yield from columns([("  value", "heard", "error", "after", "confidence"), *rows])
    if len(items) > SHOWN:
        yield f"  ... and {len(items) - SHOWN} more values"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"
