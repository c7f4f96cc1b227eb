"""Software renderer for a character's animated glTF model, with a camera and lights.

numpy fills the triangles, so no graphics card, display or system library is needed.
Points are rows: ``point @ matrix`` transforms one, as in `lipsync_lang.faces.rigs.transforms`.
"""
