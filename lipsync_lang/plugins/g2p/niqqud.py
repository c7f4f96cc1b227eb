"""Hebrew text with the vowel points that its writers leave out, as a model guesses them.

The model reads sentences, so that it tells words apart that are spelled alike. It is Nakdimon by
Elazar Gershuni (see `niqqud_licence.txt`), with weights of six bits. Words that have points keep
them.
"""

import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

import numpy as np

from lipsync_lang.base.arrays import Singles
from lipsync_lang.text.phonology.g2p.g2p_engines import RESPELLERS
from lipsync_lang.text.phonology.g2p.tokens import pieces, unmarked

MAX_READ_CHARS = 1000
"""Maximum number of characters that the model reads at once."""

_ALEF_TO_TAV = "".join(map(chr, range(0x5D0, 0x5EB)))
_SIGNS_READ = {sign: place for place, sign in enumerate(f"O5 !\"'(),-.:;?{_ALEF_TO_TAV}", start=2)}
"""Places of signs in the model: O is any sign that it does not know, and 5 any digit."""

_LIKE_SIGNS = str.maketrans("\n\t[]־–—“”״‘’׳…", "  ()---\"\"\"''',")

_LAST_PAUSE = " ."
"""The model reads the last word badly where nothing follows."""

_HYPHENED_PARTS = re.compile("[^-־]+|[-־]")

_DAGESHES = ("", "", "\u05bc")
_SHINS = ("", "", "\u05c1", "\u05c2")
_VOWELS = ("", "", *map(chr, range(0x5B0, 0x5BD)), "\u05b7")
_UNDOTTED, _UNVOWELLED = frozenset("אחםןערץ"), frozenset("םףץ")


@RESPELLERS.register("niqqud")
def respell(text: str) -> list[tuple[str, str]]:
    """Cut a text into words, each with its points, and the gaps between them."""
    bare = unmarked(text)
    marks = [
        mark
        for start in range(0, len(bare), MAX_READ_CHARS)
        for mark in _marks(bare[start : start + MAX_READ_CHARS])
    ]
    cut: list[tuple[str, str]] = []
    done = passed = 0
    for piece in pieces(text):
        between = text[done : piece.start]
        done = piece.start + len(piece.text)
        passed += len(unmarked(between))
        parts: list[tuple[str, str]] = []
        for part in _HYPHENED_PARTS.findall(piece.text):
            letters = unmarked(part)
            own = marks[passed : passed + len(letters)]
            passed += len(letters)
            pointed = "".join(map("".join, zip(letters, own, strict=True)))
            parts.append((part, pointed if letters == part else part))
        cut.append((between, between))
        if any(c.isalpha() and c not in _ALEF_TO_TAV for c in unmarked(piece.text)):
            cut += parts  # a prefix and a foreign word are two words
        else:
            cut.append((piece.text, "".join(said for _, said in parts)))
    return [*cut, (text[done:], text[done:])]


def _marks(text: str) -> list[str]:
    """Return the points of each character of a text that has none."""
    weights = _weights()
    plainly = (
        "5" if sign.isdigit() else sign for sign in text.translate(_LIKE_SIGNS) + _LAST_PAUSE
    )
    said = weights["letters"][[_SIGNS_READ.get(sign, _SIGNS_READ["O"]) for sign in plainly]]
    for layer in "12":
        forth = _run(said, weights, f"forth{layer}")
        said = forth + _run(said[::-1], weights, f"back{layer}")[::-1]
    dots, shins, vowels = (
        np.argmax(said @ weights[head] + weights[f"{head}_bias"], axis=1)
        for head in ("dots", "shins", "vowels")
    )
    return [
        (
            (_DAGESHES[dot] if letter not in _UNDOTTED else "")
            + (_SHINS[shin] if letter == "ש" else "")
            + (_VOWELS[vowel] if letter not in _UNVOWELLED else "")
        )
        if letter in _ALEF_TO_TAV
        else ""
        for letter, dot, shin, vowel in zip(text, dots, shins, vowels, strict=False)
    ]


def _run(inputs: Singles, weights: Mapping[str, Singles], layer: str) -> Singles:
    """Return the states of a layer of long short-term memory along its inputs."""
    size = len(weights[f"{layer}_state"])
    # The logistic function of the gates is half of `tanh` at half of the signal, and a half.
    steep = np.repeat(np.array([0.5, 0.5, 1, 0.5], np.float32), size)
    given = steep * (inputs @ weights[layer] + weights[f"{layer}_bias"])
    again = steep * weights[f"{layer}_state"]
    state, memory = np.zeros((2, size), np.float32)
    states = np.empty((len(inputs), size), np.float32)
    for step, signal in enumerate(given):
        risen = np.tanh(signal + state @ again).reshape(4, size)
        kept, forgot, _, out = np.float32(0.5) * (risen + 1)
        memory = forgot * memory + kept * risen[2]
        state = states[step] = out * np.tanh(memory)
    return states


@cache
def _weights() -> dict[str, Singles]:
    packed = files(__package__) / "niqqud.npz"
    with packed.open("rb") as file, np.load(file) as found:
        return {
            name: found[name] * found[f"{name}_scale"] if f"{name}_scale" in found else found[name]
            for name in found
            if not name.endswith("_scale")
        }
