"""Fixtures of the tests of coverage."""

import pytest
from coverage_packs import LANGUAGE, bank, write


@pytest.fixture
def packs(tmp_path, monkeypatch):
    """Folder with a language without a voice, and a bank."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "languages/toy.yaml", LANGUAGE)
    bank(tmp_path, "drafted")
    return tmp_path
