"""Acoustic models in the CMU Sphinx format, and their likelihoods frame by frame.

A phoneme of such a model is a sequence of three states; a frame lasts `FRAME` seconds; scores
are natural logarithms of likelihoods.
"""
