"""eSpeak NG as a library in a process of its own, for reading text and making speech."""
