"""The packs that come with the program: listed without reading them, read once in each process."""

from lipsync_lang.packs.library import Library

LIBRARY = Library(project=None)
"""All that is built in. It keeps what it has read, so tests share it and change nothing in it."""

LANGUAGES = sorted({found.name for found in LIBRARY.names("language")})
POSESETS = sorted({found.name for found in LIBRARY.names("poseset")})
assert LANGUAGES, "a sweep over nothing passes"
assert POSESETS, "a sweep over nothing passes"
