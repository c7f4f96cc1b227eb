"""Picture of the mouths of a language: each sound alone, on the model of a character."""

from collections.abc import Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from lipsync_lang.authoring.language_check import mouths_in
from lipsync_lang.errors import OutputError
from lipsync_lang.schedules.schedule import SILENCE, Schedule, Word

if TYPE_CHECKING:
    from lipsync_lang.performing.performer import Performer

HELD_SOUND_SECONDS = 0.5
"""Duration of each sound, and of the silence around it."""


def draw_mouths(performer: "Performer", sounds: Mapping[str, Any], out: BinaryIO) -> None:
    """Draw a still of each mouth, with the first sound that has it and a word.

    Sounds that pass through several mouths are left out, because each of these has a still.

    Parameters
    ----------
    performer : the language on the character
    sounds : the table of sounds (`SoundTable.told`)
    out : binary stream for a PNG

    Raises
    ------
    OutputError
        Pillow is missing, the character has no model, or the language has no sounds.
    """
    from lipsync_lang.render.sheet import moments

    shown = [own[0] for mouth, own in mouths_in(sounds).items() if len(mouth) == 1]
    if not shown:
        raise OutputError("the language maps no sounds; there is no mouth to draw")
    labels = [SILENCE, *chain.from_iterable((row["label"], SILENCE) for row in shown)]
    times = np.arange(len(labels) + 1, dtype=np.float64) * HELD_SOUND_SECONDS
    words = tuple(
        Word(next(iter(row["words"]), row["label"]), 2 * n + 1, 2 * n + 2)
        for n, row in enumerate(shown)
    )
    schedule = Schedule(tuple(labels), times, words, notation=shown[0]["notation"])
    animation = performer.rigged(performer.perform(schedule))
    middles = (times[1:-1:2] + times[2::2]) / 2
    moments(animation, middles.tolist(), out, close=True)
