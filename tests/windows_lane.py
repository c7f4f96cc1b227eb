"""Run tests as Windows would: a plugin of pytest, on top of `as_windows.py`.

    make test-windows
    PYTHONPATH=tests python -m pytest -p windows_lane tests/files -m "not full"

Modules of the package see Windows; tests and pytest see this system. A test that makes a link is
skipped, as on Windows for users without that privilege. Tests of what Windows lacks are named
below.
"""

import as_windows
import pytest

POSIX = {
    "test_an_open_descriptor_is_written_where_it_stands": "/dev/fd",
    "test_a_read_only_file_is_refused_by_its_bits_even_for_root": "bits of permission",
    "test_root_leaves_a_file_to_its_owner": "owners of files",
    "test_sources_are_on_the_disk_before_they_are_in_place": "folders that can be synced",
    "test_a_bank_that_is_edited_is_synced": "folders that can be synced",
}
"""Parts of POSIX that a test needs and Windows lacks, by the name of the test."""

OWN = "test_other_systems.py"
"""Tests of the imitation itself start processes that imitate Windows."""


def pytest_configure():
    """Imitate Windows before any test is collected."""
    as_windows.become_windows(pipes=False)


def pytest_collection_modifyitems(items):
    """Leave out the tests of the imitation, and mark those of POSIX."""
    items[:] = [item for item in items if item.path.name != OWN]
    for item in items:
        lacks = POSIX.get(item.originalname)
        if lacks:
            item.add_marker(pytest.mark.xfail(reason=f"Windows lacks {lacks}", strict=True))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call():
    """Skip a test that is not allowed to make a link."""
    outcome = yield
    error = outcome.excinfo and outcome.excinfo[1]
    if getattr(error, "winerror", None) == as_windows.NO_PRIVILEGE:
        outcome.force_exception(pytest.skip.Exception("makes a link, which needs a privilege"))
