"""The command that makes a talking head from a face model on the user's machine."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from lipsync_lang import LipsyncError
from lipsync_lang.base.files import argument_path, write_all
from lipsync_lang.commands.output import SOUND, tell_written, working
from lipsync_lang.commands.registry import Add, command, family
from lipsync_lang.commands.shared_options import option, repeated

EXAMPLE = "heads ict ICT-FaceKit -o head.glb"

family("heads", "make a talking head from a face model", EXAMPLE)


@command("heads ict")
def _add_ict(action: Add) -> None:
    made = action(
        heads,
        "make a head of 52 ARKit shapes from your clone of ICT-FaceKit",
        EXAMPLE,
        more="; its licence (MIT) goes into the file",
    )
    made.set_defaults(recipe="ict")
    made.add_argument("folder", metavar="FOLDER", type=Path, help="the clone")
    repeated(
        made, "--identity N[:WEIGHT]",
        "add identity N of the model, by 1 or WEIGHT standard deviations; repeatable",
    )  # fmt: skip
    option(made, "--seed N", "draw a person by this number", type=int)
    option(made, "--hair OBJ", "hair, in the model's lengths and place", type=Path)
    repeated(
        made, "--colour PART=#RRGGBB",
        "paint skin, lips, irises, brows, hair or another part; repeatable",
    )  # fmt: skip
    option(made, "--size MB", "largest size of the file [4]", type=float, default=4.0)
    option(
        made, "-o, --output GLB", "write the head; - is standard output", type=argument_path,
        required=True,
    )  # fmt: skip


def heads(options: Namespace) -> int:
    """Make a head and write it."""
    from lipsync_lang.plugins.heads.face_model import FaceModel, read_recipe
    from lipsync_lang.plugins.heads.made_head import HeadWish, make_head

    wish = HeadWish(
        _identities(options.identity),
        options.seed,
        options.hair,
        _colors(options.colour),
        options.size,
    )
    with working("making a head"):
        made = make_head(FaceModel(options.folder, read_recipe(options.recipe)), wish)
    write_all({options.output: lambda out: out.write(made.content)})
    size = len(made.content) / 1e6
    print(f"{made.points:,} points, {len(made.shapes)} shapes, {size:.1f} MB", file=sys.stderr)
    tell_written(options.output)
    return SOUND


def _identities(texts: Sequence[str]) -> dict[int, float]:
    found = {}
    for text in texts:
        number, _, weight = text.partition(":")
        try:
            found[int(number)] = float(weight or 1)
        except ValueError:
            what = f"--identity {text}: write a number and a weight (--identity 3:1.5)"
            raise LipsyncError(what) from None
    return found


def _colors(texts: Sequence[str]) -> dict[str, str]:
    pairs = [text.partition("=") for text in texts]
    for text, (_, mark, _) in zip(texts, pairs, strict=True):
        if not mark:
            raise LipsyncError(f"--colour {text}: write PART=#RRGGBB, such as skin=#d8a284")
    return {name: color for name, _, color in pairs}
