"""eSpeak NG as a library in a process of its own: what reads text, and what speech is made with."""
