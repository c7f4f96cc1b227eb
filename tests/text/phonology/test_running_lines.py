"""Running text as it is written, beside the same text in words: both are read alike."""

import csv
from collections import defaultdict
from pathlib import Path

import pytest
from lanes import swept

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.g2p.censored import uncensored

with (Path(__file__).parent / "running_lines.tsv").open(encoding="utf-8", newline="") as file:
    ROWS = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
LINES = defaultdict(list)
for row in ROWS:
    LINES[row["language"]].append((row["written"], row["said"]))
assert len(ROWS) > 100


def sounds(speaker, texts):
    """Return the phonemes of texts; pauses and the seams of words make no difference here."""
    read = list(speaker.transcribe_many(texts))
    if isinstance(read[0], SpeechError):
        pytest.skip(str(read[0]))
    assert not any(one.unread for one in read)
    return ["".join(name for name in one.phonemes if name != "_") for one in read]


@pytest.mark.parametrize("language", swept(LINES, quick=[*LINES][::4]))
def test_written_forms_are_read_as_their_words(language):
    written, said = zip(*LINES[language], strict=True)
    speaker = Speaker.of(language)
    pairs = zip(written, sounds(speaker, written), sounds(speaker, said), strict=True)
    assert [pair for pair in pairs if pair[1] != pair[2]] == []


@pytest.mark.parametrize("signs", ["*", "**", "@#", "#$%", "$@!#"])
@pytest.mark.parametrize("word", ["damn", "verdammter", "bastard", "cabrones"])
def test_a_vowel_behind_signs_is_no_name_of_the_signs(word, signs):
    forms = Speaker.of("english").manner.forms
    for at in (n for n, one in enumerate(word) if one in "aeiou"):
        written = word[:at] + signs + word[at + 1 :]
        (read,) = uncensored(f"You {written}!", forms)
        assert read == (4, 4 + len(written), f"{word[:at]}u{word[at + 1 :]}")


@pytest.mark.parametrize(
    "written", ["Lehrer*innen", "x*y", "C*", "a#b", "Wait!don't", "me@home.org", "**so**"]
)
def test_signs_beside_whole_words_are_no_censorship(written):
    assert not [*uncensored(f"You {written} too.", Speaker.of("english").manner.forms)]
