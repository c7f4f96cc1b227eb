"""Forced alignment: a recording and its text to a schedule with sound."""
