"""Child process that converts many texts to phonemes, without sound, and ends.

Run by path, never imported by the package, so that phonemizer, eSpeak NG, their licence and their
memory stay in a process of their own. One JSON request comes in on stdin,
``{"library", "data", "voice", "texts"}``; for each text one line of JSON goes out on stdout, its
clauses: ``["h_ə_l_oʊ w_ɜː_l_d", ...]``, phonemes joined by `_`, words by spaces. Before them comes
one line ``{}``, or ``{"error": ...}`` and no more.
"""

import ctypes
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

CHARS_UTF8 = 0x1
PHONEME_IPA = 0x2
PHONEME_SEPARATOR = "_"


def clauses(api: Any, text: str) -> Iterator[str]:
    """Yield the phonemes of a text, clause by clause."""
    pointer = ctypes.pointer(ctypes.c_char_p(text.encode("utf-8")))
    while pointer.contents.value is not None:
        found = api.text_to_phonemes(pointer, CHARS_UTF8, PHONEME_IPA | ord(PHONEME_SEPARATOR) << 8)
        if found:
            yield found.decode("utf-8", "replace").strip()


def select(api: Any, voice: str, data: str) -> dict[str, Any]:
    """Select a voice in the same way as speech; return the error, or an empty dict."""
    import espeak_worker as speech  # type: ignore[import-not-found]  # it lies beside

    listed = ctypes.cast(api.list_voices(None), ctypes.POINTER(ctypes.POINTER(speech.VoiceRecord)))
    voices = speech.read_voices(listed)
    base, plus, variant = voice.partition("+")
    identifier = speech.find_voice(voices, base)
    if plus and variant not in speech.variants(data):
        return {"error": "variant", "known": speech.variants(data)}
    if not identifier or api.set_voice_by_name((identifier + plus + variant).encode()):
        return {"error": "voice", "known": sorted(speech.names(voices))}
    return {}


def main() -> None:
    """Answer the request on stdin; output of the library goes to stderr."""
    out = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(2, 1)
    sys.path.insert(0, str(Path(__file__).parent))
    request = json.load(sys.stdin.buffer)
    from phonemizer.backend.espeak.api import EspeakAPI

    api = EspeakAPI(request["library"], request["data"])
    wrong = select(api, request["voice"], request["data"])
    print(json.dumps(wrong), file=out)
    for text in [] if wrong else request["texts"]:
        print(json.dumps(list(clauses(api, text))), file=out)
    out.flush()
    os._exit(0)  # the library's own clean-up has nothing left to give


if __name__ == "__main__":
    main()
