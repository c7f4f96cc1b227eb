"""Speech synthesis by Festival, a program of its own, as an example of a speech engine."""
