"""Packs: the YAML files people edit, their places, and their faults.

`yaml` reads text into data with positions, and defines faults. `models` holds one pydantic model
per kind of pack. `finding` and `library` look packs up by name and load them. `checking` compares
packs with each other. `splicing` changes a file and keeps the author's formatting.
"""
