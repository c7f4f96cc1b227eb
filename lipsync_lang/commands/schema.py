"""The command that prints the JSON Schema of a kind of pack."""

from argparse import Namespace

from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.commands.registry import handler


@handler("schema", "print the JSON Schema of a kind of pack", "schema language > language.json")
def schema(options: Namespace) -> int:
    """Print a schema, or the kinds that have one."""
    from lipsync_lang.packs.describe import kinds
    from lipsync_lang.packs.describe import schema as make_schema

    if options.kind is None:
        print(as_json(kinds()) if options.json else "\n".join(kinds()))
    else:
        print(as_json(make_schema(options.kind)))
    return SOUND
