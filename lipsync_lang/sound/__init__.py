"""Sound: voices that speak, and recordings that are heard."""
