"""Rigs: morph targets and bones of models, and the channels that drive them."""
