"""Read inputs up to a size limit, and write outputs atomically."""

from lipsync_lang.base.files.reading import read_input
from lipsync_lang.base.files.targets import STANDARD_STREAM, argument_path
from lipsync_lang.base.files.writing import atomic, write_all

__all__ = ["STANDARD_STREAM", "argument_path", "atomic", "read_input", "write_all"]
