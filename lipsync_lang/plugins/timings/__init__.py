"""Timings: readers of the files that aligners, voices and programs of mouth shapes write."""
