#!/usr/bin/env bash
# PyLiveLinkFace 0.1 (MIT), which sends and receives faces of Live Link Face, seen on 2026-11-30.
#
# Behaviour: a packet states its frame rate as a fraction. The library takes the rate that a program sets as the numerator,
# and a sixtieth of it, rounded down, as the denominator. At 60 frames a second that is 60/1. At 24, 25, 30 and 50 it is
# a fraction over 0, and at 120 it is 120/2, half the rate by which the same packet counts its frames. The library reads
# such packets without a complaint. All faces of a process have one device ID, too, which is made at the import.
#
# What a good engineer expects: 30 frames a second are 30/1, and each face has an ID of its own.
# What to do: correct the denominator in the packet, or send 60 frames a second, and pass a `uuid` for each face.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check PyLiveLinkFace==0.1
env/bin/python - > seen 2> errors <<'PYTHON' || { cat errors >&2; exit 1; }
import struct
from importlib.metadata import version

from pylivelinkface import PyLiveLinkFace

NAME = "Face"
# The version, the device, the length of the name, the name, and the frame with its part; all but the last are fixed.
RATE = 4 + len("$") + 36 + 4 + len(NAME) + 4 + 4

print("PyLiveLinkFace", version("PyLiveLinkFace"))
for fps in (24, 25, 30, 50, 60, 120):
    packet = PyLiveLinkFace(NAME, fps=fps).encode()
    numerator, denominator = struct.unpack_from("!II", packet, RATE)
    found, face = PyLiveLinkFace.decode(packet)
    print(f"{fps} frames a second: {numerator}/{denominator}; read again: {found}, {face.fps}")
print("two faces, one device:", PyLiveLinkFace("Ann").uuid == PyLiveLinkFace("Bob").uuid)
PYTHON
diff seen - <<'SEEN'
PyLiveLinkFace 0.1
24 frames a second: 24/0; read again: True, 24
25 frames a second: 25/0; read again: True, 25
30 frames a second: 30/0; read again: True, 30
50 frames a second: 50/0; read again: True, 50
60 frames a second: 60/1; read again: True, 60
120 frames a second: 120/2; read again: True, 120
two faces, one device: True
SEEN
echo "as before: rates other than 60 are sent as fractions over 0 or 2"
