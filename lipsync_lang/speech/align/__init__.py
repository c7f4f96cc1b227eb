"""Alignment: a recording and its text in, a schedule with the sound out."""
