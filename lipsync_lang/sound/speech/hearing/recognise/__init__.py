"""Speech recognition: a recording to words and timed phonemes."""
