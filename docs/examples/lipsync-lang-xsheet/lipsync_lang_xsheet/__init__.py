"""Exposure sheets and track sheets of drawn animation, for lipsync_lang."""
