"""Players of archives of takes, for engines: sources that stand alone, in several languages."""
