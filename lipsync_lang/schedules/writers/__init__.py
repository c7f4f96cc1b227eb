"""Writers of timings, one module per output format.

To add one, write a module here with a function ``(schedule) -> str``, and name it with its suffix
in `timing_writers.TIMING_WRITERS`. `tiers.tiers_of` gives the words and phones from time zero on,
with rounded times. The tests read each format back, so add a reader of it too. A writer in
`animations/writers/performed_timings.py` lets the outputs of a performance use the format.
"""
