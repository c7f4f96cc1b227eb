"""Fixtures of timings: a file that a test writes and reads."""

import json

import pytest

import lipsync_lang as ll


@pytest.fixture
def read(tmp_path):
    """Write a file, and read it as a schedule."""

    def run(name, text, **options):
        path = tmp_path / name
        data = text if isinstance(text, (str, bytes)) else json.dumps(text)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return ll.read_schedule(path, **options)

    return run
