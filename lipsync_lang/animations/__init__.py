"""Animations: pose weights over time, and writers for output files.

Each output format is one module; the `writer` decorator registers it.
"""
