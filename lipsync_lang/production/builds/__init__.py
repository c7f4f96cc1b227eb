"""Builds of whole games: the lines of a script, in every language, on every character.

`script.py` lists the lines that a project states, and `project_build.py` resolves their pairs.
`planning.py` compares each line with `records.py`, the record of the last build: `needs.py` knows
the values that a line read from its packs. `making.py` performs the lines that changed,
`workers.py` spreads them over processes and machines, and `build_run.py` records them and puts them
in place.
"""
