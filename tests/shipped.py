"""Built-in packs: listed without reading, and read once in each process."""

from lipsync_lang.packs.library import Library

LIBRARY = Library(project=None)
"""Library of the built-in packs; tests share it and must not change it."""

LANGUAGES = sorted({found.name for found in LIBRARY.names("language")})
POSESETS = sorted({found.name for found in LIBRARY.names("poseset")})
assert LANGUAGES, "a sweep over nothing passes"
assert POSESETS, "a sweep over nothing passes"
