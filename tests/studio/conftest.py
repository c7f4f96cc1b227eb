"""A project with a bank, and a place for a journal."""

import pytest
from packs_tree import plant


@pytest.fixture
def home(tmp_path):
    return plant(tmp_path / "project")


@pytest.fixture
def bank(home):
    return home / "posesets/face/banks/common.yaml"


@pytest.fixture
def journal(tmp_path):
    return tmp_path / "state/journal"
