"""Addresses of pages: kept for the next server, private, and for one port."""

import os
import socket
from argparse import Namespace

import pytest

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.commands.local_server import ADDRESS_SECONDS, LOCAL, _address

posix = pytest.mark.skipif(os.name != "posix", reason="modes of files")


def address(kept, host=LOCAL, port=0, token=None):
    listener, made = _address(Namespace(host=host, port=port, token=token), kept)
    with listener:
        return listener.getsockname()[1], made, listener


@pytest.fixture
def kept(tmp_path):
    return tmp_path / "state" / "project.address"


def test_the_next_server_has_the_address_of_the_last(kept):
    first = address(kept)[:2]
    assert address(kept)[:2] == first
    assert address(None)[1] != first[1]


def test_the_token_of_the_user_is_not_kept(kept):
    assert address(kept, token="chosen-by-a-person")[1] == "chosen-by-a-person"  # noqa: S106
    assert not kept.exists()
    with pytest.raises(LipsyncError, match="lets other machines in"):
        address(kept, host="0.0.0.0")  # noqa: S104


def test_a_port_that_is_taken_has_another_token(kept):
    """The program at that port may have been sent the token."""
    port, token, _ = address(kept)
    listener, _ = _address(Namespace(host=LOCAL, port=port, token="chosen-by-a-person"), None)  # noqa: S106
    with listener:
        other = address(kept)
    assert other[0] != port
    assert other[1] != token
    assert address(kept)[:2] == other[:2]


def test_answers_do_not_wait_for_a_confirmation(kept):
    listener, _ = _address(Namespace(host=LOCAL, port=0, token=None), kept)
    with listener, socket.create_connection(listener.getsockname()):
        accepted, _ = listener.accept()
        with accepted:
            assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


@posix
def test_the_file_is_for_its_owner_alone(kept):
    token = address(kept)[1]
    assert kept.stat().st_mode & 0o777 == 0o600
    kept.chmod(0o644)  # others may know it now
    assert address(kept)[1] != token
    assert kept.stat().st_mode & 0o777 == 0o600


@posix
def test_a_link_is_not_followed(kept, tmp_path):
    token = address(kept)[1]
    target = kept.rename(tmp_path / "other")
    kept.symlink_to(target)
    assert address(kept)[1] != token
    assert token in target.read_text()


def test_an_old_address_is_not_used_again(kept):
    token = address(kept)[1]
    old = kept.stat().st_mtime - ADDRESS_SECONDS - 1
    os.utime(kept, (old, old))
    assert address(kept)[1] != token


@pytest.mark.parametrize(
    "content",
    [b"", b"x", b"8765", b"0 long-enough-a-token", b"99999 long-enough-a-token", b"80 s", b"\xff"],
)
def test_another_file_is_no_address(kept, content):
    address(kept)
    kept.write_bytes(content)
    port, token, _ = address(kept)
    assert len(token) > 20
    assert port > 1023
