"""Readers of timings, one module per input format.

To add one, write a module here with a function ``(source: TimingFile) -> Schedule`` under
``@reader("name", ".suffix", sniff=sniff)`` of `timing_readers`. `sniff` tells the format by the
start of a file. `TimingFile` has the text, JSON and XML, and checks times; make the schedule with
`rows.schedule_of`, and `timed_words.timed_words_of` if there are words alone. The first line of
the function's docstring appears in `formats` and in the documentation.
"""
