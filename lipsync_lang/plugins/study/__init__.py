"""Studies: pairs of clips that raters choose between, and statistics of the choices."""
