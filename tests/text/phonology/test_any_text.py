"""Text of any languages, mixed with signs and markup, is read or refused in words."""

import csv
from functools import cache
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from lanes import swept
from shipped import LIBRARY

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.sound.speech.speaking.speaker import Speaker

SIGNS = [
    "=", "+", "-", "/", "&", "#", "%", "²", "½", "°", "€", "①", "…", "!?", "·", "'", '"', "，",
    "{name}", "%1$d", "<b>", "(laughs)", "*sighs*", "[i]", ":-)", "♪", "\u200b", "\n",
]  # fmt: skip
with (Path(__file__).parent / "running_lines.tsv").open(encoding="utf-8", newline="") as file:
    ROWS = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
PIECES = sorted({piece for row in ROWS for piece in row["written"].split()})
NAMES = [one.name for one in LIBRARY.names("language")]


@cache
def speaker_of(language):
    return Speaker.of(language)


TEXTS = st.builds(
    lambda between, pieces: between.join(pieces),
    st.sampled_from(["", " "]),
    st.lists(st.sampled_from(SIGNS) | st.sampled_from(PIECES), max_size=7),
)

TEXTS_OF_A_VOICE = 12
"""Number of texts for one start of a voice, which takes longer than to read them."""


@pytest.mark.parametrize("language", swept(NAMES, quick=["english", "mandarin", "spanish"]))
@settings(max_examples=max(2, settings().max_examples // 12))
@given(st.lists(TEXTS, min_size=TEXTS_OF_A_VOICE, max_size=TEXTS_OF_A_VOICE))
@example(["Zürich ="])
def test_pieces_of_all_languages_are_read_or_refused_in_words(language, texts):
    for read in speaker_of(language).transcribe_many(texts):
        assert isinstance(read, LipsyncError) or all(word.text for word in read.words)
