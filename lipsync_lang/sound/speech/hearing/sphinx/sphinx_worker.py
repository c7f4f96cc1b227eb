"""Decode sounds by pocketsphinx in a process of its own, which a damaged model may end.

It needs the standard library and pocketsphinx alone. Standard input has the settings of the decoder
as a line of JSON, and then for each sound its number of bytes in a line, and its 16-bit samples.
Each answer is a line of JSON: the words of the sound as (word, posterior).
"""

import json
import sys

MAX_DECODER_BYTES = 2**31


def main() -> None:
    """Answer until the input ends."""
    source, out = sys.stdin.buffer, sys.stdout
    request = json.loads(source.readline())
    sys.path[:] = request["path"]
    if sys.platform != "win32":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        least = MAX_DECODER_BYTES if most < 0 else min(MAX_DECODER_BYTES, most)
        resource.setrlimit(resource.RLIMIT_AS, (least, most))
    from pocketsphinx import Decoder

    decoder = Decoder(loglevel="FATAL", **request["settings"])
    for line in source:
        decoder.reinit_feat()  # as good as new
        decoder.start_utt()
        decoder.process_raw(source.read(int(line)), full_utt=True)
        decoder.end_utt()
        # `seg` is None where nothing was recognised
        found = [(one.word, one.prob) for one in decoder.seg() or ()]
        out.write(json.dumps(found) + "\n")
        out.flush()


if __name__ == "__main__":
    main()
