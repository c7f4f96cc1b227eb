"""Recognise words by Whisper in a process of its own, which a damaged model may end.

It needs the standard library and faster-whisper alone. Standard input has the settings of the model
as a line of JSON. The first answer has its languages, or the reason why it cannot be read. A sound
is a line of JSON with the options of its transcription and its number of bytes, and its 32-bit
samples. Its segments are an answer each, and then `null`.
"""

import json
import os
import sys


def main() -> None:
    """Answer until the input ends."""
    source, out = sys.stdin.buffer, os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # a library may print
    request = json.loads(source.readline())
    sys.path[:] = request["path"]
    settings = request["settings"]
    bytes_allowed = settings.pop("bytes")
    if sys.platform != "win32":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        least = bytes_allowed if most < 0 else min(bytes_allowed, most)
        resource.setrlimit(resource.RLIMIT_AS, (least, most))
    import numpy as np

    def answer(data: object) -> None:
        out.write(json.dumps(data) + "\n")
        out.flush()

    try:
        import faster_whisper

        model = faster_whisper.WhisperModel(**settings)
        known = model.supported_languages
        # The library lists one hundred codes for any model of many languages, also those it lacks.
        token = model.hf_tokenizer.token_to_id
        known = [code for code in known if len(known) == 1 or token(f"<|{code}|>")]
    except Exception as error:  # noqa: BLE001 several libraries read the files
        answer({"fault": str(error).strip().partition("\n")[0] or type(error).__name__})
        return
    answer({"languages": known})
    for line in source:
        options = json.loads(line)
        samples = np.frombuffer(source.read(options.pop("bytes")), np.float32)
        for one in model.transcribe(samples, **options)[0]:
            words = [
                (w.word, float(w.start), float(w.end), float(w.probability))
                for w in one.words or ()
            ]
            answer([float(one.end), float(one.no_speech_prob), float(one.compression_ratio), words])
        answer(None)


if __name__ == "__main__":
    main()
