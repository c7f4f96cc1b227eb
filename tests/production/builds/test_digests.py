"""Digests of files, which records of builds keep."""

from hashlib import blake2b

import pytest

from lipsync_lang.base.files.reading import MIB_BYTES
from lipsync_lang.production.builds.digests import CONTENT_BYTES, file_digest


@pytest.mark.parametrize("size", [0, 1, MIB_BYTES, MIB_BYTES + 1])
def test_the_digest_of_a_file_is_that_of_its_content(tmp_path, size):
    content = bytes(range(256)) * (size // 256) + b"x" * (size % 256)
    (tmp_path / "a").write_bytes(content)
    expected = blake2b(content, digest_size=CONTENT_BYTES).hexdigest()
    assert file_digest(tmp_path / "a") == expected
