"""Command handlers: argument handling and printing only; the library does the work.

Data goes to stdout, messages to stderr; each command returns its exit code.
"""
