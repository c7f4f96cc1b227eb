"""The command that adapts an acoustic model to recordings."""

import sys
from argparse import Namespace

from lipsync_lang.base.errors import count
from lipsync_lang.commands.output import FAULTS, SOUND, listening, tell_all, tell_written
from lipsync_lang.commands.registry import family, handler

ADAPT_EXAMPLE = "models adapt vo/anna -l english -o models/anna"

family("models", "adapt an acoustic model to the voices of a game", ADAPT_EXAMPLE)


@handler(
    "models adapt",
    "adapt an acoustic model to recordings and their texts",
    ADAPT_EXAMPLE,
    more=", without labels; it is written only if held-out lines become likelier",
)
def adapt(options: Namespace) -> int:
    """Adapt a model, and write it if it gains."""
    from lipsync_lang.sound.speech.hearing import adaptation
    from lipsync_lang.sound.speech.hearing.align.pocketsphinx_aligner import models_of
    from lipsync_lang.sound.speech.speaking.speaker import Speaker

    speaker = Speaker.of(options.language, options.path)
    models = models_of(options.model or speaker.manner.audio.model)
    adaptation.refuse_folder(models, options.output)
    lines = adaptation.spoken_files(options.folder)
    with listening("adapting"):
        found = adaptation.adapt(speaker, lines, models)
    tell_all(f"left out: {line}" for line in found.left_out)
    rise = f"{found.before:.2f} to {found.after:.2f}"
    print(f"{count(found.lines, 'line')}; log likelihood of held-out frames: {rise}")
    if not found.gains:
        print("the held-out lines gained nothing; no model was written", file=sys.stderr)
        return FAULTS
    adaptation.write_adapted(models, found.model, options.output)
    tell_written(options.output)
    return SOUND
