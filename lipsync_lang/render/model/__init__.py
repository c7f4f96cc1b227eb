"""A character's model, drawn: its glTF, posed in time, seen by a camera, in light.

No graphics card, display or system library is needed: triangles are filled by numpy.
Points are rows: ``point @ matrix`` moves one, as in `lipsync_lang.rigs.transforms`.
"""
