"""A project with a bank, a place for a journal, and pairs that are compiled once."""

from dataclasses import replace

import pytest
from packs_tree import plant
from places import ROOT

from lipsync_lang.packs.finding import FOLDERS
from lipsync_lang.resolver.retouch import OpenPair


@pytest.fixture(scope="session", autouse=True)
def _built_in_pairs_are_compiled_once():
    """Compile each pair of built-in packs once in a process, for projects without packs."""
    kept, compiled = {}, OpenPair.open

    def compiled_once(library, *pair):
        homes = (root.path for root in library.roots if not root.path.is_relative_to(ROOT))
        own = any((home / folder).exists() for home in homes for folder in FOLDERS.values())
        if own or library.unsaved:
            return compiled(library, *pair)
        if pair not in kept:
            kept[pair] = compiled(library, *pair)
        return replace(kept[pair], shelf=replace(kept[pair].shelf, library=library))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(OpenPair, "open", compiled_once)
        yield


@pytest.fixture
def home(tmp_path):
    return plant(tmp_path / "project")


@pytest.fixture
def bank(home):
    return home / "posesets/face/banks/common.yaml"


@pytest.fixture
def journal(tmp_path):
    return tmp_path / "state/journal"
