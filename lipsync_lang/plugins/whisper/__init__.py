"""Recognition of words in 99 languages by Whisper, and the check of its models."""
