"""Performing: a performer, what it reads of a schedule, and why each frame stands as it does."""
