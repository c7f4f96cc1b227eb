"""From a track of common phonemes to pose curves (paper, section 3.2).

Arrays in, arrays out: no files, no clock, no names. Throughout:

- times are seconds, rates are frames per second, weights are in [0, 1];
- ``(P, T)`` is poses by frames, ``(n,)`` phonemes, ``(B,)`` rows of the bigram tables;
- row 0 of the tables is rest, which stands in for a bigram that no layer has.

Order: surround and pair, warp, stitch, lay over, smooth, hold contacts, limit speed, constrain.
Each module states its conventions and where it leaves the paper. `kernel.c` repeats them, compiled.
"""
