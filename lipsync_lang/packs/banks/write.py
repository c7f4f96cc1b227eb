"""Writers of bigrams as YAML, into bank files that a person can edit."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from lipsync_lang.base.errors import LipsyncError, OutputError, PackError
from lipsync_lang.base.files.writing import cannot_write
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.value_text import INDENT, as_scalar, block_lines

CurvePoints = list[list[float]]
Interpolation = Literal["bspline", "linear"]

NEUTRAL = "neutral"
"""The default style of speaking."""


@dataclass(frozen=True)
class BankBigrams:
    """Bigrams of one pose set from any source, with the style and curve type of their bank."""

    poseset: str
    bigrams: Mapping[str, Mapping[str, CurvePoints]]
    """For each bigram, such as `l-ow`, control points by pose."""
    status: str
    style: str | None = None
    """Style of their bank; None for any style."""
    interpolation: Interpolation | None = None
    """Kind of curve; None for the bank's own."""
    character: str = ""
    """Character whose own targets were drafted; empty for the targets of the pose set."""
    owner: Path | None = None
    """File of the character for whom they were drafted; None for a bare pose set."""


def bigrams_yaml(made: BankBigrams) -> str:
    """Return bigrams as the text of a bank's `bigrams`."""
    lines = ["bigrams:" if made.bigrams else "bigrams: {}"]
    for key, curves in made.bigrams.items():
        lines += block_lines({key: {"status": made.status, "curves": curves}}, INDENT)
    return "\n".join(lines) + "\n"


def write_drafts(library: Library, drafts: BankBigrams, path: Path | None = None) -> str:
    """Add drafts to a bank or a character file; bigrams already in it stay unchanged.

    A file that the library has loaded is not read again. By default, it is `common.yaml` of the
    pose set in the project. Returns a sentence on the changes, and on who uses them.
    """
    own = drafts.owner and os.path.relpath(drafts.owner)
    if path is None and drafts.character:
        raise LipsyncError(
            f"'{drafts.character}' has its own targets, but the default bank is for all "
            f"characters of {drafts.poseset}; put the bigrams into its file (--to {own})"
        )
    shared = Path("posesets") / drafts.poseset / "banks"
    target = path or shared / "common.yaml"
    make_room(target)
    unused = "" if target.exists() else unused_bank(target, drafts.poseset, drafts.owner)
    new = add_bigrams(library, target, drafts)
    told = done(target, len(new), len(drafts.bigrams) - len(new), drafts.status)
    if path is None and own:
        told += (
            f"\nall characters of {drafts.poseset} use them; for this one alone, give --to {own}"
        )
    return f"{told}\n{unused}".rstrip()


def unused_bank(path: Path, poseset: str, owner: Path | None = None) -> str:
    """Return how a character comes to use a new bank; empty in the folder of its pose set.

    `owner` is the file of the character; None for any.
    """
    # By the end of the path, because the project may lie anywhere.
    if path.absolute().parent.parts[-3:] == ("posesets", poseset, "banks"):
        return ""
    beside = Path(os.path.relpath(path, owner.parent if owner else path.parent)).as_posix()
    who = os.path.relpath(owner) if owner else "its file"
    return f"no character uses the file yet; state `banks: [{beside}]` in {who}"


def make_room(path: Path) -> None:
    """Make the folder of a bank; raise `OutputError` for an impossible path."""
    if path.suffix != ".yaml":
        raise OutputError(f"{path}: is not a name for a bank; use a name that ends in .yaml")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path.parent, error) from None


def add_bigrams(library: Library, path: Path, made: BankBigrams) -> list[str]:
    """Add bigrams to a bank, made if missing, or to a character; return the new ones."""
    from lipsync_lang.base.files import atomic
    from lipsync_lang.packs.splicing import spliced
    from lipsync_lang.packs.yaml.pack_files import read_bytes

    create = None if path.exists() else empty_bank(made.poseset, path)
    content = read_bytes(path) if create is None else create.encode()
    source = library.scanned(path, content)
    _refuse_other(path, source.data, made)
    # `bigrams:` without a value is None.
    there = source.data.get("bigrams") or {}
    stated = {"status": made.status}
    if made.interpolation not in {None, source.data.get("interpolation", "bspline")}:
        stated["interpolation"] = str(made.interpolation)
    new = {key: curves for key, curves in made.bigrams.items() if key not in there}
    # a bank without anything new keeps its bytes and its date
    if new or create is not None:
        added = [(("bigrams", key), {**stated, "curves": new[key]}) for key in new]
        content = spliced(source, content, added)
        with atomic(path, durable=True) as stream:
            stream.write(content)
    return list(new)


def done(path: Path, new: int, kept: int, what: str) -> str:
    """Return a sentence that counts the new and the kept bigrams of a bank."""
    was, are = ("were", "are") if kept > 1 else ("was", "is")
    there = f"; {kept} {was} already there and {are} unchanged" if kept else ""
    return f"{new} {what} bigram{'' if new == 1 else 's'} put into {path}{there}"


def _refuse_other(path: Path, bank: object, made: BankBigrams) -> None:
    """Raise an error if a file is not a bank of this pose set and style, nor a character of it."""
    stated = bank if isinstance(bank, dict) else {}
    if stated.get("kind") not in {"bank", "character"} or stated.get("poseset") != made.poseset:
        raise PackError(
            f"{path}: is neither a bank nor a character of {made.poseset}; name another file for "
            "the bigrams"
        )
    if not isinstance(stated.get("bigrams") or {}, dict):
        raise PackError(f"{path}: `bigrams` is not a mapping; write `bigrams: {{}}`")
    style = stated.get("style", NEUTRAL)
    if made.style not in {None, style}:
        what = f"has bigrams of style '{style}', not '{made.style}'"
        raise PackError(f"{path}: {what}; name another file for the bigrams")


def empty_bank(poseset: str, path: Path, style: str = "") -> str:
    """Return the text of a new bank for manual bigrams, neutral unless it has a style."""
    comment = (
        "# Bigrams that a person edited or approved; all others are drafted from the targets.\n"
    )
    return comment + bank_yaml(BankBigrams(poseset, {}, "", style or None), path.stem)


def bank_yaml(made: BankBigrams, name: str) -> str:
    """Return bigrams as the text of a bank of their own."""
    return (
        f"kind: bank\nformat: 1\nname: {name}\n"
        f"poseset: {as_scalar(made.poseset)}\nlanguage: null\n"
        f"style: {as_scalar(made.style or NEUTRAL)}\n"
        f"interpolation: {made.interpolation or 'bspline'}\n"
        f"{bigrams_yaml(made)}"
    )
