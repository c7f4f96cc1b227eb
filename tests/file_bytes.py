"""Contents of files that writers make."""

from io import BytesIO

from lipsync_lang.animations.animation_writers import WRITERS


def bytes_of(name, animation):
    """Return the file of an animation in a format."""
    out = BytesIO()
    WRITERS[name].write(animation, out)
    return out.getvalue()
