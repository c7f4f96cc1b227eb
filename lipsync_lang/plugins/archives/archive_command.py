"""The commands for archives of takes: put parts together, make a patch, and apply it."""

import sys
from argparse import Namespace
from pathlib import Path

from lipsync_lang.base.errors import count
from lipsync_lang.commands.output import SOUND, as_json, tell_written
from lipsync_lang.commands.registry import Add, command, family
from lipsync_lang.commands.shared_options import add_options, option

family(
    "archive", "show archives of takes, put them together, or make patches of them",
    "archive merge takes/game.takes takes/game.*-of-16.takes",
)  # fmt: skip


@command("archive merge")
def _add_merge(action: Add) -> None:
    made = action(
        merge,
        "put the archives of shards together",
        "archive merge takes/game.takes takes/game.*-of-16.takes",
        more="; the result has the same bytes as one build",
    )
    made.add_argument("output", metavar="OUTPUT", type=Path, help="the archive to write")
    made.add_argument("parts", metavar="PART", type=Path, nargs="+", help="an archive of a shard")


@command("archive diff")
def _add_diff(action: Add) -> None:
    made = action(
        diff,
        "write a patch: only the takes that differ",
        "archive diff old/game.takes new/game.takes game.patch",
    )
    made.add_argument("old", metavar="OLD", type=Path, help="the archive that players have")
    made.add_argument("new", metavar="NEW", type=Path, help="the archive that they should have")
    made.add_argument("output", metavar="PATCH", type=Path, help="the patch to write")


@command("archive apply")
def _add_apply(action: Add) -> None:
    made = action(
        apply, "apply a patch to an archive", "archive apply game.takes game.patch -o new.takes"
    )
    made.add_argument("archive", metavar="ARCHIVE", type=Path, help="the archive to change")
    made.add_argument("patch", metavar="PATCH", type=Path, help="a file of `archive diff`")
    option(made, "-o, --output FILE", "the archive to write [ARCHIVE itself]", type=Path)


@command("archive show")
def _add_show(action: Add) -> None:
    made = action(show, "check an archive, and list its takes", "archive show game.takes")
    made.add_argument("archive", metavar="ARCHIVE", type=Path, help="an archive or a patch")
    add_options(made, ["json"])


def merge(options: Namespace) -> int:
    """Put archives together."""
    from lipsync_lang.plugins.archives.archive_patches import merged
    from lipsync_lang.production.builds.takes import write_takes

    takes = merged(options.parts)
    write_takes(options.output, takes)
    tell_written(options.output)
    print(f"{count(len(takes), 'take')} of {count(len(options.parts), 'part')}", file=sys.stderr)
    return SOUND


def diff(options: Namespace) -> int:
    """Write a patch between two archives."""
    from lipsync_lang.base.files import atomic
    from lipsync_lang.plugins.archives.archive_patches import difference
    from lipsync_lang.production.builds.takes import archive_of, read_takes

    old, new = archive_of(options.old), archive_of(options.new)
    patch = difference(old, new)
    with atomic(options.output) as out:
        out.write(patch)
    tell_written(options.output)
    changes = read_takes(options.output).takes.values()
    gone = sum(not one for one in changes)
    told = f"{count(len(changes) - gone, 'take')} changed or new, {gone} removed"
    print(f"{told}; {len(patch):,} bytes", file=sys.stderr)
    return SOUND


def apply(options: Namespace) -> int:
    """Apply a patch."""
    from lipsync_lang.plugins.archives.archive_patches import patched
    from lipsync_lang.production.builds.takes import write_takes

    # a whole file replaces the old one, so the archive may be its own output
    output = options.output or options.archive
    write_takes(output, patched(options.archive, options.patch))
    tell_written(output)
    return SOUND


def show(options: Namespace) -> int:
    """Check an archive or a patch, and list its takes."""
    from lipsync_lang.production.builds.takes import read_takes

    found = read_takes(options.archive).takes
    if options.json:
        print(as_json({name: len(one) for name, one in found.items()}))
    else:
        for name, one in found.items():
            print(f"{name}  {len(one):,} bytes" if one else f"{name}  removed")
    return SOUND
