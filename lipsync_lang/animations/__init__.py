"""Animations: pose weights over time, and the files they are written to.

One file per output format; `writer` is all that makes a format known.
"""
