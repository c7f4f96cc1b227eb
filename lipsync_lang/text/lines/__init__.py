"""Lines of a script, read from the files of games and films.

`read_lines` streams the lines of files, and of folders in order of name. Each `Line` has its
spoken text, without markup and placeholders, and its place in the file.
"""

import lazy_loader

# The stub lists the names. A performer needs markup alone, and no readers.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
