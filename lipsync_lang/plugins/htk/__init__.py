"""Acoustic models of HTK: monophones, and the features that they hear."""
