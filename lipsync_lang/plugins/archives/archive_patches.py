"""Archives of takes put together, and patches of them."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from zlib import crc32

from lipsync_lang import OutputError
from lipsync_lang.production.builds.takes import TakesFile, archive_of, encoded, read_takes


def merged(paths: Iterable[Path]) -> dict[str, bytes]:
    """Return the takes of several archives; the same take may stand in several.

    Raises OutputError if two have different takes of one name.
    """
    found: dict[str, bytes] = {}
    first: dict[str, Path] = {}
    for path in paths:
        for name, take in archive_of(path).takes.items():
            if found.setdefault(name, take) != take:
                what = f"'{name}' differs from that of {first[name]}"
                raise OutputError(f"{path}: {what}; build both parts from the same project")
            first.setdefault(name, path)
    return found


def difference(old: TakesFile, new: TakesFile) -> bytes:
    """Return the patch that makes the old archive the new one."""
    changed = {name: one for name, one in new.takes.items() if old.takes.get(name) != one}
    # a take without bytes is one that was removed
    gone = dict.fromkeys(old.takes.keys() - new.takes.keys(), b"")
    return encoded({**changed, **gone}, (_identity(old.takes), _identity(new.takes)))


def patched(path: Path, patch: Path) -> dict[str, bytes]:
    """Return the takes of an archive after a patch.

    Raises OutputError if the patch belongs to another archive.
    """
    old, change = archive_of(path), read_takes(patch)
    if change.patch is None:
        raise OutputError(f"{patch}: is an archive, not a patch; `archive diff` makes patches")
    if _identity(old.takes) != change.patch[0]:
        raise OutputError(f"{path}: is not the archive that {patch} was made for")
    takes = {name: one for name, one in {**old.takes, **change.takes}.items() if one}
    # the old archive fits, so the patch itself is damaged
    if _identity(takes) != change.patch[1]:
        raise OutputError(f"{patch}: makes another archive than it states; make it again")
    return takes


def _identity(takes: Mapping[str, bytes]) -> int:
    """Return the checksum of an archive's names and takes."""
    value = 0
    for name, take in sorted(takes.items()):
        value = crc32(take, crc32(name.encode() + b"\0", value))
    return value
