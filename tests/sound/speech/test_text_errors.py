"""Small errors of a text that fits its recording: a word out of place, a word not written."""

import re

import pytest
from lanes import full, swept

import lipsync_lang as ll
from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.hearing.sphinx import line_search
from lipsync_lang.sound.speech.hearing.sphinx.features import FRAME_SECONDS
from lipsync_lang.sound.speech.hearing.sphinx.forced import Run
from lipsync_lang.sound.speech.hearing.sphinx.line_search import MOVED_CONFIDENCE, TextErrors
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")

TEXT = "The hogs were fed chopped corn and garbage"
ORDER, UNWRITTEN = "fit better in another order", "the text does not have"


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


@pytest.fixture(scope="module")
def spoken(english):
    return english.speak(TEXT)


def told(schedule, part):
    """Return the remark with a part, or nothing."""
    return next((remark for remark in schedule.remarks if part in remark), "")


def without(words, word):
    return [one for one in words if one != word]


@pytest.mark.parametrize(
    ("text", "word", "before"),
    swept(
        [
            ("The hogs fed were chopped corn and garbage", "were", "hogs"),
            ("hogs The were fed chopped corn and garbage", "The", None),
            ("garbage The hogs were fed chopped corn and", "garbage", "and"),
        ]
    ),
)
def test_a_word_out_of_place_is_named_with_its_place(english, spoken, text, word, before):
    found = aligned(english, spoken.audio, text, aligner="pocketsphinx")
    assert found.confidence < DOUBTFUL
    place = f"after '{before}'" if before else "first"
    said = re.search(rf"such as '{word}' {place} at ([\d.]+) s; write", told(found, ORDER))
    known = next(one.start for one in spoken.words if one.text == word)
    assert float(said[1]) == pytest.approx(known, abs=0.1)


@pytest.mark.parametrize("at", swept(range(len(TEXT.split()) - 1)))
def test_any_two_neighbours_exchanged_are_reported(english, spoken, at):
    words = TEXT.split()
    words[at : at + 2] = words[at + 1], words[at]
    found = aligned(english, spoken.audio, " ".join(words), aligner="pocketsphinx")
    assert found.confidence < DOUBTFUL
    assert f"such as '{words[at + 1]}'" in told(found, ORDER)


@pytest.mark.parametrize(
    ("whole", "word"),
    [
        (TEXT, "hogs"),
        ("Kick the ball straight and follow through", "follow"),
        ("The girl at the booth sold fifty bonds", "sold"),
    ],
)
def test_a_word_that_is_not_written_is_placed_between_its_neighbours(english, whole, word):
    words, spoken = whole.split(), english.speak(whole)
    at = words.index(word)
    text = " ".join(without(words, word))
    found = aligned(english, spoken.audio, text, aligner="pocketsphinx")
    assert found.confidence >= DOUBTFUL, "the other words stand where they are said"
    pattern = rf"([\d.]+) to ([\d.]+) s, after '{words[at - 1]}' and before '{words[at + 1]}'"
    first, stop = map(float, re.search(pattern, told(found, UNWRITTEN)).groups())
    known = next(one for one in spoken.words if one.text == word)
    assert first < (known.start + known.end) / 2 < stop
    sure = {one.text: one.confidence >= DOUBTFUL for one in found.words}
    assert not sure.pop(words[at - 1])
    assert not sure.pop(words[at + 1])
    assert all(sure.values())


def test_a_right_text_has_no_such_remark(english, spoken):
    assert not aligned(english, spoken.audio, TEXT, aligner="pocketsphinx").remarks


@pytest.mark.parametrize(
    ("order", "named", "texts"),
    [
        ([2, 0, 1, 3], None, ""),
        ([1, 0, 2, 3], (1, -1), ""),
        ([2, 3, 0, 1], (0, 3), ""),
        ([0, 1, 2, 3], None, ""),
        ([1, 0, 3, 2], (1, -1), ""),
        ([3, 0, 1], (3, -1), ""),
        ([2, 3, 0, 1], (0, 3), "The dog the apple"),
        ([3, 0, 1], None, "The dog of the"),
        ([2, 3, 0, 1], None, "The dog THE dog"),
    ],
)
def test_no_place_is_named_that_sounds_or_reads_as_one_of_the_text(
    order, named, texts, monkeypatch
):
    way = [(word, Run(word, 9 * at, 9 * at + 9)) for at, word in enumerate(order)]
    monkeypatch.setattr(TextErrors, "_likeliest_order", lambda _: way)
    errors = object.__new__(TextErrors)
    errors._ways = [(1, 2), (3,), (1, 2), (4,)]
    errors._start, errors._within = 0, slice(0, 36)
    found = errors.moved_word(texts.split())
    assert (found and found[:2]) == named


def test_a_line_that_is_heard_badly_needs_more_evidence_of_another_order(
    english, spoken, monkeypatch
):
    text = "The hogs fed were chopped corn and garbage"
    found = aligned(english, spoken.audio, text, aligner="pocketsphinx")
    assert told(found, ORDER)
    monkeypatch.setattr(line_search, "GOOD_FIT", 30.0)
    found = aligned(english, spoken.audio, text, aligner="pocketsphinx")
    assert not told(found, ORDER)


@pytest.mark.parametrize("before", ["were", "hogs", "and"])
def test_a_word_that_is_not_said_is_no_other_order(english, spoken, before):
    # without it, the words have the order of the text
    text = TEXT.replace(before, f"tremendous {before}")
    found = aligned(english, spoken.audio, text, aligner="pocketsphinx")
    assert found.left_out == ("tremendous",)
    assert not told(found, ORDER)
    assert found.confidence > DOUBTFUL


@pytest.mark.parametrize(("sure", "searched"), [(0.2, True), (0.01, False)])
def test_a_line_in_doubt_is_searched_for_another_order(
    english, spoken, monkeypatch, sure, searched
):
    monkeypatch.setattr(line_search, "line_confidence", lambda _: sure)
    text = "The hogs fed were chopped corn and garbage"
    found = aligned(english, spoken.audio, text, aligner="pocketsphinx")
    assert bool(told(found, ORDER)) == searched
    assert found.confidence == (MOVED_CONFIDENCE if searched else sure)


def test_one_odd_frame_moves_no_word(english, spoken, monkeypatch):
    hogs = spoken.words[1]

    class OddListening(line_search.Listening):
        """Within "hogs", a frame is like a sound of "garbage" alone."""

        def scores(self, phones):
            scores = super().scores(phones)
            others = [n for n, one in enumerate(phones) if self.model.names[one.number] != "JH"]
            scores[round((hogs.start + hogs.end) / 2 / FRAME_SECONDS), others] -= 1e5
            return scores

    monkeypatch.setattr(line_search, "Listening", OddListening)
    found = aligned(english, spoken.audio, TEXT, aligner="pocketsphinx")
    assert not told(found, ORDER)


@full
def test_parts_of_a_text_in_another_order_are_remarked_upon(data, english, monkeypatch):
    folder = data / "recordings" / "mfa_tests"
    heard = ll.read_audio(folder / "61-70968-0000.flac")
    words = (folder / "61-70968-0000.lab").read_text("utf-8").lower().split()
    exchanged = " ".join(words[8:] + words[:8])
    found = aligned(english, heard, exchanged, aligner="pocketsphinx")
    assert found.confidence < DOUBTFUL
    assert told(found, ORDER)
    monkeypatch.setattr(TextErrors, "moved_word", lambda *_: None)
    found = aligned(english, heard, exchanged, aligner="pocketsphinx")
    assert found.confidence > DOUBTFUL, "each word fits where it stands"


@full
@pytest.mark.parametrize("gone", ["confused", "wizard"])
def test_a_word_of_a_natural_recording_that_is_not_written_is_told(data, english, gone):
    folder = data / "recordings" / "mfa_tests"
    words = (folder / "61-70968-0000.lab").read_text("utf-8").lower().split()
    text = " ".join(without(words, gone))
    found = aligned(english, folder / "61-70968-0000.flac", text, aligner="pocketsphinx")
    assert words[words.index(gone) - 1] in told(found, UNWRITTEN)
