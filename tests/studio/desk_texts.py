"""Texts and values on a desk, and a bank that somebody else changed."""

from packs_tree import BANK

from lipsync_lang.packs.yaml.building import read_yaml

STATUS = ("bigrams", "p-yu", "status")
BOUNDARY = ("bigrams", "f-a", "boundary")
THEIRS = BANK.replace("boundary: 0.4", "boundary: 0.45") + "  a-a: {curves: {}}  # new\n"


def content(desk, path):
    text = desk.text(path)
    return None if text is None else text.content


def value(desk, path, loc):
    data = read_yaml(path, content(desk, path)).data
    for step in loc:
        data = data[step]
    return data
