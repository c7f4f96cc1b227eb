"""Other takes of a line: from a file, by a plain method, or of another character."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.commands.performing import performer_for
from lipsync_lang.errors import LipsyncError

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performing.performer import Performer


def takes_against(options: Namespace, animation: "Animation") -> "dict[str, Animation]":
    """Return the animations that `--against` names, by name.

    Parameters
    ----------
    animation : performed with the same options
    """
    return {name: _take(options, animation, name) for name in options.against}


def _take(options: Namespace, animation: "Animation", name: str) -> "Animation":
    from lipsync_lang.animations.readers.animation_readers import READERS
    from lipsync_lang.quality.baselines import BASELINES
    from lipsync_lang.quality.fitting import on_model, read_for

    performer: Performer = animation.performer
    if name in BASELINES:
        return on_model(BASELINES[name](performer, animation.schedule, options.fps), performer)
    path = Path(name)
    if path.is_file() or path.suffix.lower() in READERS.suffixes():
        read, _ = read_for(performer, path, animation.schedule)
        return on_model(read, performer)
    try:
        other = performer_for(options, name)
    except LipsyncError as error:
        known = ", ".join(BASELINES)
        raise LipsyncError(
            f"--against {name}: not a file, a plain method ({known}) or a character: {error}"
        ) from None
    return other.rigged(other.perform(animation.schedule, options.fps))
