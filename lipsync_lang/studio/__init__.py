"""The page of a line, and the browser modules that it shares with the editor.

`static` holds plain ES modules without a build step. Python gathers the data of a line, packs its
arrays and puts both into one HTML file that needs nothing else.
"""
