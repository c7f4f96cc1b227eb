"""Builds of whole games: the lines of a script, in every language, on every character.

`script.py` lists the lines that a project states. `planning.py` compares each with the record of
the last build, `making.py` performs those that changed, and `records.py` keeps what was made from
what. `workers.py` spreads the work over processes and machines.
"""
