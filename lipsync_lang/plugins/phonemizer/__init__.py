"""Text to phonemes by phonemizer: orthography profiles, Festival and eSpeak NG."""
