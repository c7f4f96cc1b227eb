"""Child process that loads eSpeak NG, and speaks one text or many, or reads them.

Run by path, never imported by the package: it knows the standard library alone, so that the
engine and its licence stay in a process of their own. A JSON request comes in as the first line of
stdin; the answer goes out on stdout as a frame: `FRAME_MAGIC`, the length of a JSON header (4
bytes, little-endian), the header, and the sound as int16 in the machine's byte order.

Requests are ``{"library", "data", "task", "voice", "text", "rate"}``; the task is `speak`,
`speak_many`, `transcribe`, `voices` or `missing`. `rate` is in words per minute, 0 for the engine's
own. `data` is relative to the working directory: eSpeak NG keeps its data path in a short buffer,
and reads it in the system's encoding.

`transcribe` converts the list under ``"texts"`` to phonemes, without sound. It is answered by a
frame ``{"rate"}`` or ``{"error"}``, and by one for each text: ``{"clauses"}`` as in
``["h_ə_l_oʊ w_ɜː_l_d"]``, phonemes joined by ``_`` and words by spaces.

`speak_many` is answered by a frame ``{"rate"}`` or ``{"error"}``. Each further line of stdin is
then a text with its time limit, ``[text, seconds]``. A process forked from this one speaks it, so
that the library is always as fresh as for a first text: its second answer in one process would
differ from its first. Two frames answer the text: that of `speak`, written by the forked process,
and ``{"code", "said"}``, the exit code of that process and what the library printed.
"""

import ctypes
import json
import os
import signal
import sys
from collections.abc import Iterable
from typing import Any, BinaryIO

FRAME_MAGIC = b"lipsync1"

OUTPUT_SYNCHRONOUS = 2
PHONEME_EVENTS, PHONEME_IPA, DONT_EXIT = 0x1, 0x2, 0x8000
CHARS_UTF8 = 0x1  # neither SSML (0x10) nor [[phonemes]] (0x100): text is only ever text
PARAMETER_RATE = 1
POSITION_CHARACTER = 1
EVENT_NONE, EVENT_WORD, EVENT_PHONEME = 0, 1, 7
BUFFER_MS = 500  # each buffer holds so many events; the default is tight
NAME_BYTES = 8  # longer names are cut by the library
SEPARATOR = "\x1f"
LABEL_SEPARATOR = "_"
SAID_BYTES = 4096  # of what the library prints about one text; the rest is dropped


class _Id(ctypes.Union):
    _fields_ = (("number", ctypes.c_int), ("string", ctypes.c_char * 8), ("p", ctypes.c_void_p))


class _EspeakEvent(ctypes.Structure):
    _fields_ = (
        ("type", ctypes.c_int),
        ("unique", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("milliseconds", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", _Id),
    )


class VoiceRecord(ctypes.Structure):
    """A voice in the list of the library."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("languages", ctypes.c_void_p),
        ("identifier", ctypes.c_char_p),
        ("rest", ctypes.c_ubyte * 32),
    )


_CALLBACK = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(_EspeakEvent)
)


def _text(raw: bytes | None) -> str:
    return (raw or b"").decode("utf-8", "replace").strip()


def list_voices(library: ctypes.CDLL) -> list[tuple[str, str, list[tuple[int, str]]]]:
    """Return each voice's identifier, title and (priority, language) pairs."""
    library.espeak_ListVoices.restype = ctypes.POINTER(ctypes.POINTER(VoiceRecord))
    voices = []
    for pointer in library.espeak_ListVoices(None):
        if not pointer:  # the end of the list
            break
        row = pointer.contents
        languages, at = [], row.languages
        # Pairs of a priority, which is a byte, and a C string, until a zero byte
        while at and (priority := ctypes.string_at(at, 1)[0]):
            name = ctypes.string_at(at + 1)
            languages.append((priority, _text(name)))
            at += len(name) + 2
        voices.append((_text(row.identifier), _text(row.name), languages))
    return voices


def find_voice(voices: list[tuple[str, str, list[tuple[int, str]]]], wanted: str) -> str | None:
    """Return the identifier of a voice by identifier, its last part, title or language.

    The library's own search knows no language but the first of each voice, takes variants for
    voices, and speaks on in its default voice when it finds none.
    """
    key = wanted.lower()
    for identifier, title, _ in voices:
        if key in (identifier.lower(), identifier.lower().rpartition("/")[2], title.lower()):
            return identifier
    ranked = [
        (priority, number)
        for number, (_, _, languages) in enumerate(voices)
        for priority, language in languages
        if language.lower() == key
    ]
    return voices[min(ranked)[1]][0] if ranked else None


def names(voices: list[tuple[str, str, list[tuple[int, str]]]]) -> dict[str, str]:
    """Map the first language code of each voice, which `find_voice` takes, to its title."""
    return {
        (languages[0][1] if languages else identifier): title
        for identifier, title, languages in voices
    }


def variants(data: str) -> list[str]:
    """Return the names of the variants that may follow a voice."""
    folder = os.path.join(data, "voices", "!v")  # noqa: PTH118 pathlib costs a tenth of the start
    return sorted(os.listdir(folder)) if os.path.isdir(folder) else []  # noqa: PTH112, PTH208


def collect(library: ctypes.CDLL, text: str) -> tuple[int, list[list[Any]], list[bytes]]:
    """Speak a text; return the library's status, its events in order, and the sound in parts."""
    events: list[list[Any]] = []
    sound: list[bytes] = []

    def receive(samples: int | None, count: int, pointer: "ctypes._Pointer[_EspeakEvent]") -> int:
        if samples and count > 0:
            sound.append(ctypes.string_at(samples, 2 * count))
        number = 0
        while (event := pointer[number]).type != EVENT_NONE:
            if event.type == EVENT_PHONEME:
                events.append(["phoneme", event.sample, event.id.string.decode("latin-1")])
            elif event.type == EVENT_WORD:
                events.append(["word", event.sample, event.text_position])
            number += 1
        return 0

    # The name keeps it alive: Python does not know that the library calls it.
    callback = _CALLBACK(receive)
    library.espeak_SetSynthCallback(callback)
    raw = text.encode("utf-8") + b"\0"
    length = ctypes.c_size_t(len(raw))
    status = library.espeak_Synth(raw, length, 0, POSITION_CHARACTER, 0, CHARS_UTF8, None, None)
    return status, events, sound


def clauses(library: ctypes.CDLL, text: str, separator: str) -> list[str]:
    """Return the phonemes of each clause by their whole names, stress marks included."""
    library.espeak_TextToPhonemes.restype = ctypes.c_char_p
    buffer = ctypes.create_string_buffer(text.encode("utf-8"))
    pointer = ctypes.c_void_p(ctypes.addressof(buffer))
    found: list[str] = []
    while pointer.value:
        # Bits 8 to 23 of the mode are the separator (speak_lib.h).
        clause = library.espeak_TextToPhonemes(
            ctypes.byref(pointer), CHARS_UTF8, PHONEME_IPA | ord(separator) << 8
        )
        found += [_text(clause)] if clause else []
    return found


def prepare(library: ctypes.CDLL, request: dict[str, Any]) -> dict[str, Any]:
    """Initialise the library; return ``{"rate"}`` in hertz if it can speak, else the answer."""
    data, options = os.fsencode(request["data"]), PHONEME_EVENTS | PHONEME_IPA | DONT_EXIT
    rate = library.espeak_Initialize(OUTPUT_SYNCHRONOUS, BUFFER_MS, data, options)
    if rate <= 0:
        return {"error": "data"}
    voices = list_voices(library)
    if request["task"] == "voices":
        return {"voices": names(voices)}
    if request["task"] == "missing":
        asked = request["text"].split("\n")
        missing = [one for one in asked if not find_voice(voices, one.partition("+")[0])]
        return {"missing": missing, "voices": names(voices)}
    base, plus, variant = request["voice"].partition("+")
    identifier = find_voice(voices, base)
    known = variants(request["data"])
    if plus and variant not in known:
        return {"error": "variant", "known": known}
    if not identifier or library.espeak_SetVoiceByName((identifier + plus + variant).encode()):
        return {"error": "voice", "known": sorted(names(voices))}
    if request["rate"]:
        library.espeak_SetParameter(PARAMETER_RATE, request["rate"], 0)
    return {"rate": rate}


def speak(library: ctypes.CDLL, text: str, rate: int) -> tuple[dict[str, Any], list[bytes]]:
    """Speak a text with the prepared library; return the header and the sound."""
    status, events, sound = collect(library, text)
    if status:
        return {"error": "synthesis", "status": status}, []
    cut = any(kind == "phoneme" and len(name) == NAME_BYTES for kind, _, name in events)
    found = clauses(library, text, SEPARATOR) if cut else []
    spelled = [name for clause in found for name in clause.replace(SEPARATOR, " ").split()]
    size = sum(map(len, sound))
    return {"rate": rate, "events": events, "spelled": spelled, "bytes": size}, sound


def speak_many(library: ctypes.CDLL, rate: int, out: BinaryIO) -> None:
    """Answer each text as its line comes in."""
    for line in sys.stdin.buffer:
        text, seconds = json.loads(line)
        reader, writer = os.pipe()
        child = os.fork()
        if not child:
            # The alarm's own action ends it: Python handles no signal while the library hangs.
            signal.setitimer(signal.ITIMER_REAL, seconds)
            try:
                os.set_blocking(writer, False)  # a library that prints without end does not wait
                os.dup2(writer, 1)
                os.dup2(writer, 2)
                send(out, *speak(library, text, rate))
                os._exit(0)
            finally:
                os._exit(1)
        os.close(writer)
        _, status = os.waitpid(child, 0)
        said = os.read(reader, SAID_BYTES)
        os.close(reader)
        code = os.waitstatus_to_exitcode(status)
        send(out, {"code": code, "said": said.decode("utf-8", "replace")})


def send(out: BinaryIO, header: dict[str, Any], sound: Iterable[bytes] = ()) -> None:
    """Write a frame."""
    raw = json.dumps(header).encode("ascii")
    out.writelines((FRAME_MAGIC, len(raw).to_bytes(4, "little"), raw, *sound))
    out.flush()


def main() -> None:
    """Answer the request on stdin; output of the library goes to stderr."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    request = json.loads(sys.stdin.buffer.readline())
    library = ctypes.CDLL(request["library"])
    ready = prepare(library, request)
    if request["task"] == "speak" and "rate" in ready:
        send(out, *speak(library, request["text"], ready["rate"]))
    else:
        send(out, ready)
    if request["task"] == "speak_many" and "rate" in ready:
        speak_many(library, ready["rate"], out)
    for text in request.get("texts", ()) if "rate" in ready else ():
        send(out, {"clauses": clauses(library, text, LABEL_SEPARATOR)})
    os._exit(0)  # the library's own clean-up has nothing left to give


if __name__ == "__main__":
    main()
