"""SmartBody speech markup (BML): the curves of one spoken line.

Based on `sbm_speech_audiofile.cpp` and the sample lines of SmartBody. `<curves>` holds a `<curve>`
per viseme, with four numbers per key: seconds of the sound, weight, and two unused slopes. Keys may
have negative times. `<sync>` marks are the start and end of words. The file belongs next to an
audio file of the same name and is played by `<speech ref="NAME"/>`, for characters with visemes in
curve mode. Interpolation is linear, unless the character requests splines; so keys are those of
lines, with `keys` too.
"""

from functools import partial
from html import escape
from typing import TextIO

from lipsync_lang.animations.fixed import boneless, shape_columns
from lipsync_lang.animations.keys import ERROR
from lipsync_lang.animations.writers import Animation, writer


@writer("smartbody", suffix=".bml", remarks=partial(boneless, program="SmartBody"))
def write_smartbody(animation: Animation, out: TextIO) -> None:
    """SmartBody's curves of a line: keyframes of visemes, and when its words begin and end."""
    times = (animation.schedule.times + animation.offset).tolist()
    out.write('<?xml version="1.0" encoding="utf-8"?>\n<bml>\n  <speech id="sp1">\n    <text>\n')
    out.writelines(
        f'      <sync id="T{2 * number}" time="{times[word.first]:.3f}"/>'
        f"{escape(_known(word.text), quote=False)}"
        f'<sync id="T{2 * number + 1}" time="{times[word.stop]:.3f}"/>\n'
        for number, word in enumerate(animation.schedule.words)
    )
    out.write("    </text>\n  </speech>\n  <curves>\n")
    shift = animation.offset - animation.begins
    curves = animation.keyframes(ERROR, lines=True)
    for curve in (curves[number] for number in shape_columns(animation)):
        points = zip((curve.times + shift).tolist(), curve.values.tolist(), strict=True)
        keys = " ".join(f"{time:.6f} {value:.6f} 0 0" for time, value in points)
        attributes = f'name="{escape(_known(curve.name))}" num_keys="{len(curve.times)}"'
        out.write(f'    <curve {attributes} owner="analysis">{keys}</curve>\n')
    out.write("  </curves>\n</bml>\n")


def _known(text: str) -> str:
    """Remove the characters that XML cannot represent."""
    return "".join(letter if letter.isprintable() else "\ufffd" for letter in text)
