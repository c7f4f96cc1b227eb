"""Text to timed phonemes and sound: speech engines, and the joining of their parts."""
