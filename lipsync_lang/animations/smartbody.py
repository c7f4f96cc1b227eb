"""Behaviour markup for SmartBody: the curves of one spoken line.

After `sbm_speech_audiofile.cpp` and the lines that come with SmartBody: `<curves>` holds a
`<curve>` for each viseme, whose text is four numbers a key (seconds of the sound, weight, and two
slopes, which it does not use); keys may lie below zero. `<sync>` marks say when words begin and
end. The file goes beside a sound of the same name, and is played by `<speech ref="NAME"/>` where
the character's visemes are set to curves. Keys are joined by straight lines, unless the character
asks for splines.
"""

from collections.abc import Iterator
from html import escape
from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer
from lipsync_lang.animations.fixed import boneless, shape_columns
from lipsync_lang.animations.keys import ERROR, Curve


def remarks(animation: Animation) -> Iterator[str]:
    """Yield, in words, what the file does not hold."""
    return boneless(animation, "SmartBody")


@writer("smartbody", suffix=".bml", remarks=remarks)
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
    curves = animation.keyframes(ERROR)
    out.writelines(_curve(curves[number], shift) for number in shape_columns(animation))
    out.write("  </curves>\n</bml>\n")


def _curve(curve: Curve, shift: float) -> str:
    points = zip((curve.times + shift).tolist(), curve.values.tolist(), strict=True)
    keys = " ".join(f"{time:.6f} {value:.6f} 0 0" for time, value in points)
    name = f'"{escape(_known(curve.name))}"'
    return f'    <curve name={name} num_keys="{len(curve.times)}" owner="analysis">{keys}</curve>\n'


def _known(text: str) -> str:
    """Return a text without the characters that XML has no way to write."""
    return "".join(letter if letter.isprintable() else "\ufffd" for letter in text)
