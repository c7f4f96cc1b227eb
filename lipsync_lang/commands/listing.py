"""Commands that list what there is beside packs."""

from argparse import Namespace
from collections.abc import Sequence

from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.errors import LipsyncError

SHOWN = 4
"""Suffixes that a line has room for."""


def voices(options: Namespace) -> int:
    """Print the voices of a speech engine."""
    from lipsync_lang.errors import did_you_mean
    from lipsync_lang.speech import ENGINES
    from lipsync_lang.text_table import columns

    if options.engine not in ENGINES:
        raise LipsyncError(
            f"no speech engine '{options.engine}'; {did_you_mean(options.engine, ENGINES)}"
        )
    found = ENGINES[options.engine].voices()
    print(as_json(found) if options.json else "\n".join(columns(sorted(found.items()))))
    return SOUND


def formats(options: Namespace) -> int:
    """Print every registered reader and writer."""
    from lipsync_lang.animations.readers.registry import load_animation_readers
    from lipsync_lang.animations.registry import load_writers
    from lipsync_lang.lines.registry import load_readers as load_line_readers
    from lipsync_lang.schedules.registry import load_readers
    from lipsync_lang.text_table import columns

    rows = [
        *(("read", r.name, r.suffixes, r.title) for r in load_readers().values()),
        *(("lines", r.name, r.suffixes, r.title) for r in load_line_readers().values()),
        *(("judge", r.name, (r.suffix,), r.title) for r in load_animation_readers().values()),
        *(("write", w.name, (w.suffix,), w.title) for w in load_writers().values()),
    ]
    if options.json:
        keys = ("direction", "name", "suffix", "title")
        told = [(kind, name, " ".join(suffixes), title) for kind, name, suffixes, title in rows]
        print(as_json([dict(zip(keys, row, strict=True)) for row in told]))
    else:
        shown = [(kind, name, _shown(suffixes), title) for kind, name, suffixes, title in rows]
        print("\n".join(columns(shown)))
    return SOUND


def _shown(suffixes: Sequence[str]) -> str:
    """Return the first suffixes of many."""
    return " ".join(suffixes[:SHOWN]) + (" ..." if len(suffixes) > SHOWN else "")
