"""The command that explains the weight of each pose at a time."""

from argparse import Namespace

from lipsync_lang.commands.output import SOUND, as_json
from lipsync_lang.commands.performing import perform
from lipsync_lang.commands.registry import handler


@handler(
    "explain",
    "explain the weight of each pose at a time",
    'explain "Hello, world" -l english -c facefx --at 0.42',
    more="; in the folder of a project, --line alone explains the line of its script",
)
def explain(options: Namespace) -> int:
    """Explain one frame."""
    explanation = perform(options).explain(options.at)
    print(as_json(explanation.to_dict()) if options.json else explanation)
    return SOUND
