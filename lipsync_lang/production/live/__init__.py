"""Live characters: each text is spoken when it arrives, and frames go to an engine in real time."""
