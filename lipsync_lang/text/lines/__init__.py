"""Lines of a script, read from the files of games and films.

`read_lines` streams the lines of files, and of folders in order of name. Each `Line` has its
spoken text, without markup and placeholders, and its place in the file.
"""

from lipsync_lang.text.lines.line_readers import Line as Line
from lipsync_lang.text.lines.line_readers import read_lines as read_lines
