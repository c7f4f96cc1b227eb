"""Studio: the editor in the browser, and the page of a line, which shares its modules.

`static` holds plain ES modules without a build step. Python gathers the data of a line, packs its
arrays and writes both into one self-contained HTML file.
"""
