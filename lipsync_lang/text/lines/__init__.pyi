# The public names of the room; each is imported from its module on first use.

from .line_readers import Line as Line
from .line_readers import read_lines as read_lines
