"""Addresses of the receivers of live frames."""

from typing import NamedTuple

from lipsync_lang.base.errors import LipsyncError, did_you_mean

STANDARD_OUTPUT = "-"
USUAL_PORTS = {"livelink": 11111, "vmc": 39539, "ws": 8765}
LOCAL = "127.0.0.1"
MAX_PORT = 65535


class LiveAddress(NamedTuple):
    """A receiver of frames."""

    kind: str
    """A kind of `USUAL_PORTS`, or `STANDARD_OUTPUT`."""
    host: str = ""
    port: int = 0


def parse_address(text: str) -> LiveAddress:
    """Parse ``livelink:HOST:PORT``, ``vmc:HOST:PORT``, ``ws:HOST:PORT`` or ``-``.

    The defaults are this machine and the usual port of the receiver. An IPv6 address is in
    brackets.

    >>> parse_address("vmc:192.168.1.20:39540")
    LiveAddress(kind='vmc', host='192.168.1.20', port=39540)
    >>> parse_address("livelink")
    LiveAddress(kind='livelink', host='127.0.0.1', port=11111)
    """
    if text == STANDARD_OUTPUT:
        return LiveAddress(text)
    kind, _, rest = text.partition(":")
    if kind not in USUAL_PORTS:
        raise LipsyncError(
            f"--to {text}: '{kind}' is not a kind of receiver; {did_you_mean(kind, USUAL_PORTS)}. "
            "Write KIND:HOST:PORT, or - for standard output"
        )
    # An IPv6 address has colons of its own, so that only brackets tell where its port begins.
    if rest.startswith("["):
        host, _, port = rest[1:].partition("]")
        port = port.removeprefix(":")
    else:
        host, colon, port = rest.rpartition(":")
        if not colon and not rest.isdecimal():  # a number without a host is a port
            host, port = rest, ""
    if port and not (port.isascii() and port.isdecimal() and 0 < int(port) <= MAX_PORT):
        what = f"--to {text}: '{port}' is not a port; give a number from 1 to {MAX_PORT}"
        raise LipsyncError(what)
    return LiveAddress(kind, host or LOCAL, int(port) if port else USUAL_PORTS[kind])
