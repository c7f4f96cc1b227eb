"""The three output formats of Rhubarb Lip Sync: TSV, XML and JSON.

Based on its README and exporters (github.com/DanielSWolf/rhubarb-lip-sync). Shapes are A to H, and
X for rest. Times are seconds with two decimals, from 0 to the end of the sound; each shape ends at
the start of the next. `soundFile` is the source of the schedule, because the name of the output
audio file is unknown here.
"""

import json
from html import escape
from pathlib import Path
from typing import TextIO

from lipsync_lang import OutputError
from lipsync_lang.animations.fixed import names
from lipsync_lang.animations.held import HeldShape, held
from lipsync_lang.animations.writers import Animation, template, writer
from lipsync_lang.base.errors import shortlist

RHUBARB_NAMES = Path(__file__).with_name("rhubarb-names.txt")
"""List of the shapes' names, with the rest shape last."""


def _refuse_others(animation: Animation) -> dict[str, str]:
    """Return Rhubarb's names by their folded form; refuse poses of other names."""
    known = {name.casefold(): name for name in names(RHUBARB_NAMES).shapes}
    poses = animation.without_gestures().poses
    others = [pose for pose in poses if pose.casefold() not in known]
    if others:
        unknown = f"{shortlist(others)} {'is' if len(others) == 1 else 'are'} unknown"
        mend = "perform on a character that has those shapes (-c rhubarb)"
        known_ones = ", ".join(known.values())
        raise OutputError(f"Rhubarb's mouth shapes are {known_ones}, and {unknown}; {mend}")
    return known


@writer("rhubarb-tsv", suffix=".tsv", refuse=_refuse_others)
def write_tsv(animation: Animation, out: TextIO) -> None:
    """Rhubarb's table of mouth shapes: the start of each, and the end of the sound."""
    shapes = _shapes(animation)
    out.writelines(f"{shape.start:.2f}\t{shape.name}\n" for shape in shapes)
    out.write(f"{shapes[-1].end:.2f}\t{names(RHUBARB_NAMES).shapes[-1]}\n")


@writer("rhubarb-xml", suffix=".xml", refuse=_refuse_others)
def write_xml(animation: Animation, out: TextIO) -> None:
    """Rhubarb's mouth shapes as XML: the start and end of each."""
    shapes = _shapes(animation)
    # XML 1.0 cannot represent other characters.
    source = animation.schedule.source
    file = "".join(c if c in "\t\n\r" or c.isprintable() else "\ufffd" for c in source)
    cues = "".join(
        f'    <mouthCue start="{shape.start:.2f}" end="{shape.end:.2f}">{shape.name}</mouthCue>\n'
        for shape in shapes
    )
    name = escape(file, quote=False)
    out.write(template(__file__)[0].format(file=name, duration=shapes[-1].end, cues=cues))


@writer("rhubarb-json", suffix=".rhubarb.json", refuse=_refuse_others)
def write_json(animation: Animation, out: TextIO) -> None:
    """Rhubarb's mouth shapes as JSON: the start and end of each."""
    shapes = _shapes(animation)
    # Rhubarb writes two decimals, also in JSON, where `json.dumps` would write 0.1 for 0.10.
    cues = ",\n".join(
        f'    {{ "start": {shape.start:.2f}, "end": {shape.end:.2f}, "value": "{shape.name}" }}'
        for shape in shapes
    )
    file = json.dumps(animation.schedule.source, ensure_ascii=False)
    out.write(template(__file__)[1].format(file=file, duration=shapes[-1].end, cues=cues))


def _shapes(animation: Animation) -> list[HeldShape]:
    """Return the held shapes under Rhubarb's names, ignoring case."""
    known = _refuse_others(animation)
    shapes = held(animation, names(RHUBARB_NAMES).shapes[-1])
    return [shape._replace(name=known[shape.name.casefold()]) for shape in shapes]
