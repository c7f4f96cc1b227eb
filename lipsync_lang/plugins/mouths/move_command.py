"""The command that moves a bank of bigrams to another face."""

import sys
from argparse import Namespace
from pathlib import Path

from lipsync_lang import OutputError
from lipsync_lang.base.files import STANDARD_STREAM, argument_path, atomic
from lipsync_lang.commands.output import SOUND, as_json, tell_all, tell_written
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_options, option


@command("bank move")
def _add_move(action: Add) -> None:
    made = action(
        move,
        "move the bigrams of a face to another face, by the mouths that they show",
        "bank move common.yaml --to head.glb -o moved.yaml",
        more=", and tell what is lost",
    )
    made.add_argument("bank", metavar="BANK", type=Path, help="the file of a bank")
    option(
        made, "--from FACE",
        "the face that it was drawn for: a character, a pose set or a model [the bank's pose set]",
        dest="source",
    )  # fmt: skip
    option(
        made, "--to FACE", "the other face: a character, a pose set or a model such as head.glb",
        dest="goal", required=True,
    )  # fmt: skip
    option(
        made, "-o, --output FILE", "write the new bank; - is standard output [only tell the loss]",
        type=argument_path,
    )  # fmt: skip
    add_options(made, ["path", "json"])


def move(options: Namespace) -> int:
    """Move a bank; tell the loss, the worst first."""
    from lipsync_lang.packs.banks.write import make_room, unused_bank
    from lipsync_lang.packs.library import Library
    from lipsync_lang.plugins.mouths.bank_move import move_bank

    output = options.output
    if output not in {None, STANDARD_STREAM} and output.exists():
        raise OutputError(f"{output}: is already there; name another file")
    library = Library(options.path)
    moved = move_bank(library, options.bank, options.source, options.goal)
    if output is not None:
        name = options.bank.stem if output == STANDARD_STREAM else output.stem
        if output != STANDARD_STREAM:
            make_room(output)
        with atomic(output, durable=True) as stream:
            stream.write(moved.yaml(name).encode())
    words = sys.stderr if output == STANDARD_STREAM else sys.stdout
    print(as_json(moved.to_dict()) if options.json else moved.told(), file=words)
    if output is not None:
        tell_written(output)
    if output not in {None, STANDARD_STREAM}:
        own = [Path(file) for file in library.lookup("character", options.goal)]
        unused = unused_bank(output, moved.goal.poseset.name, *own[:1])
        tell_all([unused] if unused else [])
    return SOUND
