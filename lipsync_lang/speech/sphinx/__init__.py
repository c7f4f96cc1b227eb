"""Acoustic models in the form of CMU Sphinx: what they hear in a sound, frame by frame.

A phoneme of such a model is three states in a row; a sound is cut into frames of `FRAME` seconds;
scores are natural logarithms of likelihoods.
"""
