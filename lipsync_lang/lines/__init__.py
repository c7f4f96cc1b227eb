"""Lines of a script: what is to be spoken, read from the files that dialogue is kept in.

`read_lines` streams them: files, and folders in order of name. Each `Line` has its spoken text
without markup and placeholders, and where it stands.
"""

from lipsync_lang.lines.line import Line
from lipsync_lang.lines.line_readers import read_lines

__all__ = ["Line", "read_lines"]
