"""Commands about banks."""

import sys
from argparse import Namespace

from lipsync_lang.commands.output import SOUND


def bank(options: Namespace) -> int:
    """Draft bigrams; print them as YAML or put them into a bank."""
    from lipsync_lang.banks.write import draft_yaml, write_drafts
    from lipsync_lang.packs.library import Library
    from lipsync_lang.resolver.drafts import draft_bigrams

    library = Library(options.path)
    drafts = draft_bigrams(library, options.language, options.character, options.bigrams)
    if options.write or options.to:
        print(write_drafts(drafts, options.to), file=sys.stderr)
    else:
        print(draft_yaml(drafts), end="")
    return SOUND
