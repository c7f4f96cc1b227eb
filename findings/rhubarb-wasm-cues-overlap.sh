#!/usr/bin/env bash
# rhubarb-lip-sync-wasm 0.1.8 (npm, MIT), seen on 2026-11-28; the voice is espeakng-loader 0.2.4.
#
# Behaviour: mouth cues overlap. Where Rhubarb puts a closed mouth A before a shape, the port leaves the end of the cue
# before it in place: the next cue starts before the one before it ends, and both end at once.
#
# What a good engineer expects: cues in a row, as the files of Rhubarb itself have them.
# What to do: a shape lasts until the next one starts, whatever its end says.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check espeakng-loader==0.2.4
npm init --yes > /dev/null
npm install --silent --no-audit --no-fund rhubarb-lip-sync-wasm@0.1.8
env/bin/python - <<'PYTHON'
import ctypes
from array import array

import espeakng_loader

sound = array("h")


@ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p)
def heard(wave, count, _events):
    if count > 0:
        sound.extend(wave[:count])
    return 0


library = ctypes.CDLL(espeakng_loader.get_library_path())
rate = library.espeak_Initialize(2, 0, espeakng_loader.get_data_path().encode(), 0)
library.espeak_SetSynthCallback(heard)
library.espeak_SetVoiceByName(b"en-us")
text = b"Please buy five more maps before Bob moves away."
library.espeak_Synth(text, len(text) + 1, 0, 0, 0, 1, None, None)
library.espeak_Synchronize()
wanted = 16_000
samples = (sound[at * rate // wanted] for at in range(len(sound) * wanted // rate))
with open("voice.pcm", "wb") as file:
    file.write(array("h", samples).tobytes())
PYTHON
cat > cues.mjs <<'SCRIPT'
import { readFileSync, writeFileSync } from "node:fs";
import { Rhubarb } from "rhubarb-lip-sync-wasm";

const dialogText = "Please buy five more maps before Bob moves away.";
const { mouthCues } = await Rhubarb.getLipSync(readFileSync("voice.pcm"), { dialogText });
const early = mouthCues.filter((cue, at) => at > 0 && cue.start < mouthCues[at - 1].end);
const same = early.every((cue) => cue.end === mouthCues[mouthCues.indexOf(cue) - 1].end);
const shapes = [...new Set(early.map((cue) => cue.value))].join(" ");
writeFileSync("seen", `some cues start early: ${early.length > 0}; shapes: ${shapes}; ends are equal: ${same}\n`);
SCRIPT
node cues.mjs > log 2>&1 || { cat log >&2; exit 1; }
diff seen - <<'SEEN'
some cues start early: true; shapes: A; ends are equal: true
SEEN
echo "as before: a closed mouth starts before the cue in front of it has ended"
