"""Readers of timings, one module per input format.

To add one, write a module in `plugins/timings`, whose entry point names its suffixes, with a
function ``(source: TimingFile) -> Schedule`` under ``@reader("name", ".suffix", sniff=sniff)`` of
`timing_readers`. `sniff` tells the format from those of other readers by the start of a file;
``methodcaller("holds", "words")`` is one for JSON with a key. `TimingFile` has the
text, JSON and XML, finds the fields of lines (`matches`), and checks times. Make the schedule with
`rows.schedule_of`, or timed words with `timed_words.timed_words_of`. The first line of the
function's docstring appears in `formats` and in the documentation. Then run
`docs/build_reference.py`. The tests need an example and a seed, both files of the format.
"""
