"""Built-in packs: listed without reading, and read once in each process."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import pytest
from places import ROOT

from lipsync_lang.packs.checking import pack_checks, validate
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import validation
from lipsync_lang.packs.yaml import building
from lipsync_lang.resolver import cache as pair_cache
from lipsync_lang.resolver import language_tables

LIBRARY = Library(project=None)
"""Library of the built-in packs; tests share it and must not change it."""

LIBRARY.extended = cache(LIBRARY.extended)  # languages are put together once

LANGUAGES = sorted({found.name for found in LIBRARY.names("language")})
POSESETS = sorted({found.name for found in LIBRARY.names("poseset")})
assert LANGUAGES, "a sweep over nothing passes"
assert POSESETS, "a sweep over nothing passes"
RESTING = sorted(
    {one.name for one in LIBRARY.names("language") if b"\nmotion:" not in one.path.read_bytes()}
)
"""Languages with the motion of the pose set; that of a language may keep other promises.

A look into the bytes of a pack takes no time; to read all packs would take two seconds.
"""


KEPT_PAIRS = 16
"""Number of compiled pairs that a process keeps; each has some megabytes."""

KEPT_FORMS = 100
"""Number of languages whose written forms a process keeps."""


@contextmanager
def read_once() -> Iterator[None]:
    """Parse and check each built-in pack once, however many libraries a process opens.

    Other bytes in its place, and files of tests, are read as ever.
    """
    scan, validated = building.scan, validation.validated
    kept_scan, kept_validated = cache(scan), cache(validated)

    def scan_once(path, content):
        return (kept_scan if _is_built_in(path) else scan)(path, content)

    def validated_once(source, **expected):
        return (kept_validated if _is_built_in(source.path) else validated)(source, **expected)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "scan", scan_once)
        patch.setattr(validation, "validated", validated_once)
        patch.setattr(pack_checks, "check_labels", _checked_once(pack_checks.check_labels))
        patch.setattr(validate, "check_claims", _checked_once(validate.check_claims))
        patch.setattr(language_tables, "forms_of", _formed_once(language_tables.forms_of))
        _load_pairs_once(patch)
        yield


def _load_pairs_once(patch):
    """Digest and decode a file of the cache of pairs once, as long as it has the same bytes."""
    unsealed, compiled = pair_cache.unsealed, pair_cache._compiled  # noqa: SLF001 behind all checks
    kept = {}

    def unsealed_once(mark, path):
        content = path.read_bytes() if path else b""
        name = content[: len(mark) + pair_cache.CHECKSUM]
        if name in kept and kept[name][0] == content:
            return memoryview(kept[name][0])[len(name) :]
        rest = unsealed(mark, path)
        kept[name] = [rest.obj, None]
        while len(kept) > KEPT_PAIRS:
            del kept[next(iter(kept))]
        return rest

    def compiled_once(head, body):
        own = next((one for one in kept.values() if one[0] is body.obj), [b"", None])
        own[1] = own[1] or compiled(head, body)
        return own[1]

    patch.setattr(pair_cache, "unsealed", unsealed_once)
    patch.setattr(pair_cache, "_compiled", compiled_once)


def _checked_once(check):
    """Return a check that keeps the faults of built-in languages, as long as all is the same."""
    kept = {}

    def checked_once(pack, *others):
        if not all(_is_built_in(source.path) for source in pack.sources):
            return check(pack, *others)
        given = (pack.model, *others)
        if pack.sources not in kept or kept[pack.sources][0] != given:
            kept[pack.sources] = given, tuple(check(pack, *others))
        return kept[pack.sources][1]

    return checked_once


def _formed_once(forms_of):
    """Return a function that keeps the written forms of a language, for its very models."""
    kept = {}

    def formed_once(language, common, notation):
        key = id(language), id(common), notation
        if key not in kept:
            # the models stay with their forms, so that no other model has their identity
            kept[key] = forms_of(language, common, notation), language, common
            while len(kept) > KEPT_FORMS:
                del kept[next(iter(kept))]
        return kept[key][0]

    return formed_once


def _is_built_in(path):
    return any(path.is_relative_to(ROOT / folder) for folder in ("languages", "posesets"))
