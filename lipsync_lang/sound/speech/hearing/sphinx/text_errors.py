"""Search for small errors of a text that fits its sound: a word out of place, a word not written.

Each word may fit where it stands although the text is wrong. So the words are searched once more,
with one of them elsewhere, and once with other speech between them. What that gains is the doubt.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Singles
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import (
    OUTSIDE,
    AcousticModel,
    Listening,
    WordPosition,
)
from lipsync_lang.sound.speech.hearing.sphinx.features import FRAME_SECONDS
from lipsync_lang.sound.speech.hearing.sphinx.forced import (
    Graph,
    HeardPhoneme,
    Node,
    Pronunciations,
)
from lipsync_lang.sound.speech.hearing.sphinx.trellis import SOUND_START, Run, likeliest_way

MIN_WORDS = 3
"""Fewest words of a text that is searched."""

REACH = 8
"""Most words over which a word is moved."""

EXCHANGED_LOG, MOVED_LOG, PARTS_LOG = -28.0, -60.0, -100.0
"""Log scores of two neighbours exchanged, of a word moved further, and of two parts exchanged."""

ORDER_FLOOR_LOG = -12.0
"""Least log likelihood of a frame relative to the likeliest phoneme, in the search of orders."""

ENTER_PHONE_LOG = -4.0
"""Log score for entering a phoneme of speech without words."""

UNWRITTEN_LOG, ENTER_UNWRITTEN_LOG = -3.0, -25.0
"""Log scores of unwritten speech, for each frame and for its start.

Those of frames are relative to the line's own words: the worse a model hears a language, the worse
it hears them, too.
"""

UNWRITTEN_PHONES = 3
"""Fewest phonemes of unwritten speech."""

MIN_UNWRITTEN_FRAMES = 33
"""Fewest frames of unwritten speech that is reported; 2 % of right lines have as many."""

MIN_OTHER_FRAMES = 50
"""Fewest frames of other sound that is reported as such: it is no word of the line."""

MARGIN_FRAMES = 60
"""Frames before and after the words that are searched for unwritten speech."""

ORDER_MARGIN_FRAMES = 20
"""The same for another order of the words: music is more like some of them."""

PAUSE = Node(OUTSIDE, 0, WordPosition.INSIDE)
SPEECH = Node(OUTSIDE, OUTSIDE, WordPosition.INSIDE)
"""Speech without words; both have the context and the states of silence."""


class MovedWord(NamedTuple):
    """A word of a text that is said after another one, or first (`OUTSIDE`), from a frame on."""

    word: int
    after: int
    first: int

    def told(self, texts: Sequence[str]) -> str:
        """Describe it in a remark."""
        place = f"after '{texts[self.after]}'" if self.after != OUTSIDE else "first"
        return (
            f"the words fit better in another order, such as '{texts[self.word]}' {place} at "
            f"{self.first * FRAME_SECONDS:.1f} s; write them in the order of the recording"
        )


class UnwrittenSpeech(NamedTuple):
    """Frames with speech that the text does not have, before a word (the number of all: after)."""

    before: int
    first: int
    stop: int

    def told(self, texts: Sequence[str]) -> str:
        """Describe it in a remark."""
        sides = [f"after '{texts[self.before - 1]}'"] if self.before else []
        sides += [f"before '{texts[self.before]}'"] if self.before < len(texts) else []
        times = (f"{at * FRAME_SECONDS:.1f}" for at in (self.first, self.stop))
        return f"{' to '.join(times)} s, {' and '.join(sides)}"


class TextErrors:
    """Search for errors of a text.

    Parameters
    ----------
    model : acoustic model
    features : (T, ...) of the sound, less the mean of the voice
    words : pronunciations in the order of the text
    heard : phonemes that `lay` found
    margin : frames before and after the words that are searched for another order
    """

    def __init__(
        self,
        model: AcousticModel,
        features: Floats,
        words: Sequence[Pronunciations],
        heard: Sequence[HeardPhoneme],
        margin: int = ORDER_MARGIN_FRAMES,
    ) -> None:
        self._model = model
        self._said = [one for one in heard if OUTSIDE not in (one.word, one.phone)]
        ways: list[tuple[int, ...]] = [()] * len(words)
        for one in self._said:
            ways[one.word] += (one.phone,)
        # the pronunciation that is heard, or the first one of a word that is left out
        self._ways = [way or some[0] for way, some in zip(ways, words, strict=True)]
        first, stop = self._said[0].first, self._said[-1].stop
        self._others = [one for one in heard if one.word == one.phone == OUTSIDE]
        before, after = self._other_frames(0, first), self._other_frames(stop, len(features))
        # Another voice beside the line is like some of its words. It is searched only where words
        # are left out, which may be said there.
        self._start = first if before >= MIN_OTHER_FRAMES else max(first - MARGIN_FRAMES, 0)
        end = stop if after >= MIN_OTHER_FRAMES else stop + MARGIN_FRAMES
        if not all(ways):
            first = self._start = 0
            stop = end = len(features)
        self._within = slice(max(first - margin - self._start, 0), stop + margin - self._start)
        self._sound = Listening(model, features[self._start : end])
        self._alone = self._sound.scores(model.alone)
        speech = [n for n in range(len(model.alone)) if n not in model.fillers]
        self._best = self._alone[:, speech].max(axis=(1, 2))

    def moved_word(self) -> MovedWord | None:
        """Return the word that fits much better in another place, if there is one.

        Of two parts that are exchanged, it is the first word of the sound.
        """
        way = self._likeliest_order()
        order = list(dict.fromkeys(word for word, _ in way))
        if order == sorted(order):
            return None
        rests = ([*order[:at], *order[at + 1 :]] for at in range(len(order)))
        # without a single word that moved, the halves are exchanged
        at = next((n for n, rest in enumerate(rests) if rest == sorted(rest)), 0)
        first = next(run.first for word, run in way if word == order[at])
        first += self._start + self._within.start
        return MovedWord(order[at], order[at - 1] if at else OUTSIDE, first)

    def _likeliest_order(self) -> list[tuple[int, Run]]:
        """Return the phonemes of the likeliest order of the words, with the price of another one.

        One word is moved, or two parts are exchanged.
        """
        graph, count = Graph(self._model), len(self._ways)
        joins: list[list[int]] = [[SOUND_START], *([] for _ in range(count))]
        early: list[list[int]] = [[] for _ in range(count)]
        prices: dict[int, float] = {}

        def spoken(word: int, ends: Sequence[int], price: float = 0.0) -> list[int]:
            """Add a word after others, and an optional pause."""
            pause = graph.add(PAUSE, OUTSIDE, OUTSIDE, ends)
            prices[len(graph.nodes)] = price
            return graph.word(word, [self._ways[word]], OUTSIDE, OUTSIDE, [*ends, pause])

        for at in range(count):
            before = joins[at]
            # later: the words after this one, and then this one
            last = before
            for other in range(at + 1, min(at + REACH + 1, count)):
                last = spoken(other, last)
                price = MOVED_LOG if other > at + 1 else EXCHANGED_LOG
                joins[other + 1] += spoken(at, last, price)
            # earlier: a word from further on, here or before, and then those up to this one
            for other in range(at + 2, min(at + REACH + 1, count)):
                early[other] = spoken(at, [*early[other], *spoken(other, before, MOVED_LOG)])
            if at + 1 < count:
                joins[at + 2] += spoken(at, early[at + 1])
            joins[at + 1] += spoken(at, before)
        ends = joins[count]
        # from any word to the last, and then from the first on
        last = []
        for word in range(1, count):
            last = spoken(word, [SOUND_START, *last])
        for word in range(count - 1):
            last = spoken(word, last, 0.0 if word else PARTS_LOG)
            ends += last
        ends.append(graph.add(PAUSE, OUTSIDE, OUTSIDE, ends))
        # without context: a model knows those of its own language alone
        scores = self._alone[self._within, self._phones(graph)]
        floor = self._best[self._within] + np.float32(ORDER_FLOOR_LOG)
        np.maximum(scores, floor[:, None, None], out=scores)
        way = self._way(graph, scores, ends, prices)
        runs = [(graph.nodes[run.phone].word, run) for run in way]
        return [(word, run) for word, run in runs if word != OUTSIDE]

    def unwritten(self) -> list[UnwrittenSpeech]:
        """Return speech that no word of the text explains, within the words and beside them."""
        phones, likely = self._phone_loop()
        said = np.concatenate([np.arange(one.first, one.stop) for one in self._said]) - self._start
        fit = sum(one.fit * (one.stop - one.first) for one in self._said)
        usual = (fit + (self._best - likely)[said].sum()) / len(said)
        graph, silence = Graph(self._model), self._model.silence
        prices: dict[int, float] = {}

        def gap(ends: Sequence[int]) -> list[int]:
            """Add an optional pause, speech of three phonemes' length or more, and a pause."""
            quiet = graph.add(PAUSE, silence, silence, ends)
            last = [*ends, quiet]
            prices[len(graph.nodes)] = ENTER_UNWRITTEN_LOG
            for _ in range(UNWRITTEN_PHONES):
                last = [graph.add(SPEECH, silence, silence, last)]
            return [*ends, quiet, *last, graph.add(PAUSE, silence, silence, last)]

        ends: list[int] = [SOUND_START]
        for word, way in enumerate(self._ways):
            left = self._ways[word - 1][-1] if word else silence
            right = self._ways[word + 1][0] if word + 1 < len(self._ways) else silence
            ends = graph.word(word, [way], left, right, gap(ends))
        ends = gap(ends)
        scores = self._sound.scores(self._model.phones(graph.contexts))
        other = [node == SPEECH for node in graph.nodes]
        scores[:, other] = (likely + np.float32(usual + UNWRITTEN_LOG))[:, None, None]
        found: list[UnwrittenSpeech] = []
        word = 0
        for run in self._way(graph, scores, ends, prices):
            node = graph.nodes[run.phone]
            one = UnwrittenSpeech(word, run.first + self._start, run.stop + self._start)
            if node == SPEECH and found and found[-1].stop == one.first:
                found[-1] = found[-1]._replace(stop=one.stop)
            elif node == SPEECH:
                found.append(one)
            elif node.word != OUTSIDE:
                word = node.word + 1
        return [one for one in found if self._told(one, phones)]

    def _told(self, one: UnwrittenSpeech, phones: Sequence[Run]) -> bool:
        """Return True for speech that may be a word, and that is not reported as other sound."""
        middles = [(phone.first + phone.stop) / 2 + self._start for phone in phones]
        many = sum(one.first <= at < one.stop for at in middles) >= UNWRITTEN_PHONES
        other = self._other_frames(one.first, one.stop)
        return many and one.stop - one.first >= MIN_UNWRITTEN_FRAMES and other < MIN_OTHER_FRAMES

    def _other_frames(self, first: int, stop: int) -> int:
        """Return how many frames of a span are neither words nor pauses."""
        return sum(max(0, min(o.stop, stop) - max(o.first, first)) for o in self._others)

    def _phone_loop(self) -> tuple[list[Run], Singles]:
        """Return the likeliest phonemes of speech without words, and the likelihood of frames."""
        count = len(self._model.alone)
        follows = [[SOUND_START, *range(count)]] * count
        turns = np.full(count, ENTER_PHONE_LOG)
        runs = likeliest_way(self._alone, self._model.stay, follows, turns=turns) or []
        likely = [self._alone[run.first : run.stop, run.phone].max(axis=1) for run in runs]
        spoken = [run for run in runs if run.phone not in self._model.fillers]
        return spoken, np.concatenate(likely)

    def _phones(self, graph: Graph) -> list[int]:
        silence = self._model.silence
        return [silence if node.word == OUTSIDE else node.phone for node in graph.nodes]

    def _way(
        self, graph: Graph, scores: Singles, ends: Sequence[int], prices: Mapping[int, float]
    ) -> list[Run]:
        """Return the likeliest path; it is empty if the words are longer than the sound.

        `prices` are log scores for entering nodes.
        """
        stay, turns = self._model.stay[self._phones(graph)], np.zeros(len(graph.nodes))
        turns[[*prices]] = [*prices.values()]
        return likeliest_way(scores, stay, graph.before, ends, turns) or []
