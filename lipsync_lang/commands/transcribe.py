"""The command that shows the phonemes of a text."""

import sys
from argparse import Namespace

from lipsync_lang.commands.output import FAULTS, SOUND, as_json, lines_of, listed, tell_all
from lipsync_lang.commands.registry import handler
from lipsync_lang.commands.shared_options import cleaning


@handler(
    "transcribe",
    "show the phonemes and common phonemes of a text",
    'transcribe "Hello, world" -l english',
)
def transcribe(options: Namespace) -> int:
    """Print the phonemes and common phonemes of texts, word by word."""
    from lipsync_lang.authoring.printing import transcript_table
    from lipsync_lang.sound.speech.needed_extras import engines_of, refuse_missing
    from lipsync_lang.sound.speech.speaking.speaker import Speaker

    texts = [options.text] if options.text is not None else lines_of(options.file)
    speaker = Speaker.of(options.language, options.path, cleaning(options))
    refuse_missing({speaker.manner.language: engines_of(speaker.manner)})
    heard = list(speaker.transcribe(texts))
    if options.json:
        print(as_json([speaker.to_json(transcript) for transcript in heard]))
    else:
        print("\n\n".join(transcript_table(speaker.to_json(t)) for t in heard))
    for transcript in heard:
        remarks = [*transcript.remarks, *transcript.advice]
        for what, which in (
            ("no mapping for", transcript.unmapped),
            ("not read:", transcript.unread),
            ("not spoken:", transcript.dropped),
        ):
            remarks += [f"{what} {listed(which)}"] if which else []
        tell_all(f"{transcript.text[:40]}: {remark}" for remark in remarks)
    if speaker.manner.weak:
        print(speaker.manner.weak, file=sys.stderr)
    return FAULTS if any(one.unmapped for one in heard) else SOUND
