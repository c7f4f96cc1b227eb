"""Packs: the YAML files people edit, where they are found, and what is wrong with them.

`faults` says what is wrong, `source` reads YAML with positions, `models` gives each kind
of pack its form, `library` finds and loads packs, `checks` compares them with each other,
`schema` and `edit` serve editors.
"""
