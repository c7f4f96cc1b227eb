#!/usr/bin/env bash
# eSpeak NG 1.52 in espeakng-loader 0.2.4 (GPL-3), seen on 2026-11-28.
#
# Behaviour: the library gives the phonemes of a text in two ways: as text (`espeak_TextToPhonemes`) and as events
# beside the sound (`espeakINITIALIZE_PHONEME_EVENTS | espeakINITIALIZE_PHONEME_IPA`). The two differ for one word
# and one voice: events leave out length marks in Finnish, Japanese and Arabic, though the sound is long, and may give
# palatalisation as an event of its own with a time of its own (Irish and Japanese here, Russian d not).
#
# What a good engineer expects: the same labels from one engine, so that labels can be joined with their times.
# What to do: align the two by position, take the label from the text and the time from the event, and give the
# time of a lone modifier to the sound before it.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check espeakng-loader==0.2.4
"$work/env/bin/python" - > "$work/seen" 2> "$work/errors" <<'PYTHON' || { cat "$work/errors" >&2; exit 1; }
import ctypes
from ctypes import POINTER, Structure, c_char_p, c_int, c_short, c_uint, c_void_p

import espeakng_loader


class Event(Structure):
    _fields_ = [
        ("type", c_int), ("unique", c_uint), ("text_position", c_int), ("length", c_int),
        ("audio_position", c_int), ("sample", c_int), ("user", c_void_p), ("name", ctypes.c_char * 8),
    ]


PHONEME, RETRIEVAL, UTF8, IPA = 7, 2, 1, 2
names = []


@ctypes.CFUNCTYPE(c_int, POINTER(c_short), c_int, POINTER(Event))
def heard(_wave, _count, events):
    at = 0
    while events[at].type:
        if events[at].type == PHONEME:
            names.append(events[at].name.decode())
        at += 1
    return 0


library = ctypes.CDLL(espeakng_loader.get_library_path())
library.espeak_Info.restype = c_char_p
library.espeak_TextToPhonemes.restype = c_char_p
library.espeak_Initialize(RETRIEVAL, 0, espeakng_loader.get_data_path().encode(), 1 | 2)
library.espeak_SetSynthCallback(heard)
print(library.espeak_Info(None).decode())
for voice, word in (
    ("fi", "kukka"), ("ja", "おおきい"), ("ar", "كِتَاب"), ("ja", "きょう"), ("ga", "uisce"), ("ru", "день"),
    ("it", "palla"), ("en-us", "bird"),
):
    library.espeak_SetVoiceByName(voice.encode())
    raw = word.encode()
    rest = c_void_p(ctypes.addressof(text := ctypes.create_string_buffer(raw)))
    told = library.espeak_TextToPhonemes(ctypes.byref(rest), UTF8, IPA | ord("_") << 8).decode()
    names.clear()
    library.espeak_Synth(raw, len(raw) + 1, 0, 0, 0, UTF8, None, None)
    library.espeak_Synchronize()
    print(voice, "text", " ".join(told.split("_")), "| events", " ".join(filter(None, names)))
PYTHON
diff "$work/seen" - <<'SEEN'
1.52.0
fi text k ˈu kː a | events k ˈu k a
ja text ˈo̞o̞ k iː | events ˈo̞ k i
ar text k i t ˌaː b | events k i t ˈa b
ja text kʲ ˈo̞ ɯᵝ | events k ʲ ˈo̞ ɯᵝ
ga text ˈɪ ʃ kʲ ə | events ˈɪ ʃ k ʲ ə
ru text dʲ ˈe n | events dʲ ˈe n
it text p ˈa l l a | events p ˈa l l a
en-us text b ˈɜː d | events b ˈɜː d
SEEN
echo "as before: the events of eSpeak NG lack length marks, and part palatalisation from its sound"
