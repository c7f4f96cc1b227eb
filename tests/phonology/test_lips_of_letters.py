"""Letters whose lips the engines got wrong, in words of everyday speech."""

import pytest

from lipsync_lang.errors import SpeechError
from lipsync_lang.speech.speaking.speaker import Speaker

WORDS = [
    ("ukrainian", "вода", "w ao d aa"),  # the lips round before о and у, and before consonants
    ("ukrainian", "все", "w s eh"),
    ("ukrainian", "вплив", "w bmp l ih w"),
    ("ukrainian", "вік", "f iy kg"),
    ("ukrainian", "двері", "d f eh d iy"),
    ("ukrainian", "філософ", "f iy l ao s ao f"),
    ("spanish", "vaca", "bmp aa kg aa"),
    ("spanish", "la vaca", "l aa bw aa kg aa"),
    ("spanish", "abogado", "aa bw oc kg aa th oc"),
    ("spanish", "hombre", "oc bmp bmp d eh"),
    ("galician", "vaca", "bmp aa kg aa"),
    ("galician", "avogado", "aa bw oc kg aa th oc"),
    ("galician", "nabo árbore", "n aa bw oc aa d bw oc d eh"),
    ("galician", "convite", "kg oc bmp bmp iy d eh"),
    ("polish", "w domu", "f d ao bmp w"),
]


@pytest.mark.parametrize(("language", "text", "mouths"), WORDS)
def test_words_have_the_mouths_of_their_letters(language, text, mouths):
    (found,) = Speaker.of(language).transcribe([text])
    assert " ".join(found.phonemes) == mouths


@pytest.mark.parametrize("text", ["בית", "בעולם", "בזכויות", "בני"])
def test_bet_closes_the_lips_where_a_hebrew_word_begins(text):
    (found,) = Speaker.of("hebrew").transcribe_many([text])
    if isinstance(found, SpeechError):
        pytest.skip(str(found))
    assert found.phonemes[0] == "bmp"
