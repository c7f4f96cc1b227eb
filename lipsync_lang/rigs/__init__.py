"""Rigs: which morph targets and bones a model has, and what drives them."""
