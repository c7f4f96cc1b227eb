"""Search for the words of a line in its sound, and in parts of the sound if they hardly fit.

Music or another voice beside a line may be like some of its words. Then these are drawn away from
their place, or a phoneme lasts as long as the music. Without that sound they are found.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, pairwise
from math import exp
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints, Singles
from lipsync_lang.schedules.schedule import DOUBTFUL, OTHER_ORDER
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import (
    OUTSIDE,
    AcousticModel,
    Listening,
    WordPosition,
)
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    FRAME_SECONDS,
    HOP_SAMPLES,
    HeardFrames,
    PreparedSound,
    voice_span,
)
from lipsync_lang.sound.speech.hearing.sphinx.forced import (
    SOUND_START,
    WINDOW_FRAMES,
    Graph,
    HeardPhoneme,
    Node,
    Pronunciations,
    Run,
    centred,
    lay,
    likeliest_way,
)
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import line_confidence

if TYPE_CHECKING:
    from lipsync_lang.sound.speech.hearing.sphinx.folder import Models

MIN_WORDS = 3
"""Fewest words of a text that is searched."""

REACH = 8
"""Most words over which a word is moved."""

ORDER_LOGS = -22.0, -60.0, -120.0
"""Log scores of two neighbours exchanged, of a word moved further, and of two parts exchanged."""

GOOD_FIT, MISFIT_WEIGHT = -3.5, 0.5
"""Mean fit of a line below which chance gains more by another order, and the share of these scores
that each unit below it adds to them."""

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

MOVED_CONFIDENCE = 0.05
"""Greatest confidence of a line with a word that fits better elsewhere, and the least one of a line
that is searched for such a word."""

MAX_PARTED_FRAMES = 4000
"""Most frames of a sound that is parted: 40 s."""

MIN_BESIDE_FRAMES = 100
"""Fewest frames of the sound beside a line that is left out, and of each part."""

CHANGE_STEP_FRAMES = 10
"""Frames between the places where a sound may change."""

MIN_VARIANCE = 1e-3
"""Variance of a feature in digital silence."""

CHANGE_DEPTH = 2
"""Number of times that a sound is halved where it changes most: four stretches."""

PART_MARGIN_FRAMES = 30
"""Frames beyond a change that are searched with the part before or after it."""

MIN_PART_PACE = 6
"""Fewest frames of a part for each phoneme of the line."""

PART_LOGIT = -1.0
"""Weight in the logit of a line's confidence of the choice among parts.

A wrong text, too, fits some part better than the whole.
"""

WORDS_ALONE_LOGIT = -3.0
"""The same of a search without other sound, which would show where a wrong text fits nothing."""


class MovedWord(NamedTuple):
    """A word of a text that is said after another one, or first (`OUTSIDE`), from a frame on."""

    word: int
    after: int
    first: int

    def told(self, texts: Sequence[str]) -> str:
        """Describe it in a remark."""
        place = f"after '{texts[self.after]}'" if self.after != OUTSIDE else "first"
        return (
            f"{OTHER_ORDER}, such as '{texts[self.word]}' {place} at "
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
    """Search for small errors of a text that fits: a word out of place, a word not written.

    Each word may fit where it stands although the text is wrong. So the words are searched once
    more, with one of them elsewhere, and once with other speech between them. What that gains is
    the doubt.

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
        misfit = GOOD_FIT - float(np.mean([one.fit for one in self._said]))
        self._misheard = 1 + MISFIT_WEIGHT * max(0.0, misfit)
        ways: list[tuple[int, ...]] = [()] * len(words)
        for one in self._said:
            ways[one.word] += (one.phone,)
        # the pronunciation that is heard, or the first one of a word that is left out
        self._lost = {word for word, way in enumerate(ways) if not way}
        self._ways = [way or some[0] for way, some in zip(ways, words, strict=True)]
        first, stop = self._said[0].first, self._said[-1].stop
        self._others = [one for one in heard if one.word == one.phone == OUTSIDE]
        before, after = self._other_frames(0, first), self._other_frames(stop, len(features))
        # Another voice beside the line is like some of its words. It is searched only where words
        # are left out, which may be said there.
        self._start = first if before >= MIN_OTHER_FRAMES else max(first - MARGIN_FRAMES, 0)
        end = stop if after >= MIN_OTHER_FRAMES else stop + MARGIN_FRAMES
        if self._lost:
            first, self._start, stop, end = 0, 0, len(features), len(features)
        self._within = slice(max(first - margin - self._start, 0), stop + margin - self._start)
        self._sound = Listening(model, features[self._start : end])
        self._alone = self._sound.scores(model.alone)
        speech = [n for n in range(len(model.alone)) if n not in model.fillers]
        self._best = self._alone[:, speech].max(axis=(1, 2))

    def moved_word(self, texts: Sequence[str] = ()) -> MovedWord | None:
        """Return the word that fits much better in another place, if there is one.

        Of two parts that are exchanged, it is the first word of the sound, or that of the text. A
        place that sounds as one of the text is none, and neither is one with the words of one, if
        `texts` has them: a word is repeated, or another one sounds so.
        """
        way, texts = self._likeliest_order(), [text.casefold() for text in texts]
        order = list(dict.fromkeys(word for word, _ in way))
        if order == sorted(order):
            return None
        rests = [[*order[:at], *order[at + 1 :]] for at in range(len(order))]
        moved = [n for n, rest in enumerate(rests) if rest == sorted(rest)]
        # without a single word that moved, parts are exchanged, or words at several places
        after_it = dict(pairwise(sorted(order)))
        moved = moved or [n for n, one in enumerate(order) if after_it.get(order[n - 1]) != one]
        for at in moved:
            after = order[at - 1] if at else OUTSIDE
            if not any(_follows(known, after, order[at]) for known in (self._ways, texts)):
                first = next(run.first for word, run in way if word == order[at])
                return MovedWord(order[at], after, first + self._start + self._within.start)
        return None

    def _likeliest_order(self) -> list[tuple[int, Run]]:
        """Return the phonemes of the likeliest order; moves of words or of parts have a price."""
        graph, count = Graph(self._model), len(self._ways)
        joins: list[list[int]] = [[SOUND_START], *([] for _ in range(count))]
        early: list[list[int]] = [[] for _ in range(count)]
        prices: dict[int, float] = {}
        exchanged, moved, parts = (self._misheard * log for log in ORDER_LOGS)

        def spoken(word: int, ends: Sequence[int], price: float = 0.0) -> list[int]:
            """Add a word after others, and an optional pause; a word that is left out may lack."""
            pause = graph.add(PAUSE, OUTSIDE, OUTSIDE, ends)
            prices[len(graph.nodes)] = price
            said = graph.word(word, [self._ways[word]], OUTSIDE, OUTSIDE, [*ends, pause])
            return [*said, *ends] if word in self._lost else said

        for at in range(count):
            before = joins[at]
            # later: the words after this one, and then this one
            last = before
            for other in range(at + 1, min(at + REACH + 1, count)):
                last = spoken(other, last)
                joins[other + 1] += spoken(at, last, moved if other > at + 1 else exchanged)
            # earlier: a word from further on, here or before, and then those up to this one
            for other in range(at + 2, min(at + REACH + 1, count)):
                early[other] = spoken(at, [*early[other], *spoken(other, before, moved)])
            if at + 1 < count:
                joins[at + 2] += spoken(at, early[at + 1])
            joins[at + 1] += spoken(at, before)
        ends = joins[count]
        # from any word to the last, and then from the first on
        last = []
        for word in range(1, count):
            last = spoken(word, [SOUND_START, *last])
        for word in range(count - 1):
            last = spoken(word, last, 0.0 if word else parts)
            ends += [one for one in last if one != SOUND_START]
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
        """Return the likeliest path by log `prices` of nodes; empty if the sound is too short."""
        stay, turns = self._model.stay[self._phones(graph)], np.zeros(len(graph.nodes))
        turns[[*prices]] = [*prices.values()]
        return likeliest_way(scores, stay, graph.before, ends, turns) or []


def _follows(words: Sequence[object], before: int, word: int) -> bool:
    """Return True if a word equal to one follows a word equal to another, or begins the text."""
    known = [None, *words]
    return bool(words) and (known[before + 1], words[word]) in pairwise(known)


class FoundLine(NamedTuple):
    """Phonemes of a line, if its words were found, with its confidence and errors of its text."""

    heard: list[HeardPhoneme]
    sure: float
    moved: MovedWord | None = None
    unwritten: tuple[UnwrittenSpeech, ...] = ()


def found_line(
    models: "Models",
    sound: PreparedSound,
    words: Sequence[Pronunciations],
    texts: Sequence[str] = (),
) -> FoundLine:
    """Search for words in a sound, without a steady noise before and after the voice.

    If they hardly fit, they are searched in its parts between changes, too. Speech that is not
    written may be music that holds a word back, as well. A word before a pause, as in "Hey... Um",
    may be taken for other sound, so all sound is tried as the words', too.
    """
    end = -(-len(sound) // HOP_SAMPLES)
    first, stop = voice_span(sound, end)
    if stop - first < end:
        inside = _in_parts(models, sound.part(first, stop), words, texts)
        if inside.heard:
            return _placed(inside, (first, stop), end)
    return _in_parts(models, sound, words, texts)


def _in_parts(
    models: "Models", sound: PreparedSound, words: Sequence[Pronunciations], texts: Sequence[str]
) -> FoundLine:
    """Search for words in a sound, and in its parts if they hardly fit."""
    whole = _found(models, sound, words, texts)
    sure = whole.sure >= DOUBTFUL and not whole.unwritten
    if sure or len(sound) > MAX_PARTED_FRAMES * HOP_SAMPLES:
        return whole
    if whole.sure < DOUBTFUL and any(one.word == one.phone == OUTSIDE for one in whole.heard):
        every = _chosen(_found(models, sound, words, texts, words_alone=True), WORDS_ALONE_LOGIT)
        if every.sure >= DOUBTFUL:
            return every
    shortest = MIN_PART_PACE * sum(len(ways[0]) for ways in words)
    features = models.model.front_end(sound.samples())
    parts = [one for one in sound_parts(features) if one[1] - one[0] >= shortest]
    alone = (_alone(models, sound, words, part, len(features)) for part in parts)
    return max([whole, *alone], key=lambda one: one.sure)


def _placed(found: FoundLine, part: tuple[int, int], end: int) -> FoundLine:
    """Return a line that is found in a part of a sound with the rest as other sound."""
    spans = (0, part[0]), (part[1], end)
    before, after = ([HeardPhoneme(OUTSIDE, OUTSIDE, *span, 0.0)] for span in spans)
    found = _timed(found, lambda frame: frame + part[0])
    heard = [*before, *found.heard, *after]
    return found._replace(heard=[one for one in heard if one.stop > one.first])


def _timed(found: FoundLine, at: Callable[[float], float]) -> FoundLine:
    """Return a line whose frames are `at` others."""

    def span(one: Any) -> Any:
        return one._replace(first=round(at(one.first)), stop=round(at(one.stop)))

    heard = [
        span(one)._replace(late=float(at(one.first + one.late)) - round(at(one.first)))
        for one in found.heard
    ]
    moved = found.moved and found.moved._replace(first=round(at(found.moved.first)))
    return FoundLine(heard, found.sure, moved, tuple(map(span, found.unwritten)))


def _found(  # noqa: PLR0913 the line and options
    models: "Models",
    sound: PreparedSound,
    words: Sequence[Pronunciations],
    texts: Sequence[str] = (),
    margin: int = ORDER_MARGIN_FRAMES,
    *,
    words_alone: bool = False,
) -> FoundLine:
    heard, features = best_heard(models, sound, words, words_alone=words_alone)
    line = FoundLine(heard, line_confidence(heard))
    # a line in doubt may pass by another aligner, which does not tell the order of words
    few = len(features) <= WINDOW_FRAMES and len(words) >= MIN_WORDS
    if line.sure >= MOVED_CONFIDENCE and few:
        errors = TextErrors(models.model, centred(features, heard)[:], words, heard, margin)
        moved = errors.moved_word(texts)
        sure = line.sure if moved is None else min(line.sure, MOVED_CONFIDENCE)
        line = FoundLine(heard, sure, moved, tuple(errors.unwritten()))
    if (starts := features.starts) is None:
        return line
    return _timed(line, partial(np.interp, xp=np.arange(len(starts)), fp=starts))


def best_heard(
    models: "Models",
    sound: PreparedSound,
    words: Sequence[Pronunciations],
    *,
    words_alone: bool = False,
) -> tuple[list[HeardPhoneme], HeardFrames]:
    """Align words, as `laid` does, in the features of the sound that fit best; return both.

    These are the features of its changing frames.
    """
    every = models.model.front_end.hearings(sound)
    hearings = (replace(one.changing(), words_alone=words_alone) for one in every)
    tries = ((laid(models, one, words) or [], one) for one in hearings)
    return max(tries, key=lambda one: line_confidence(one[0]))


def sound_parts(features: Floats) -> Iterator[tuple[int, int]]:
    """Yield the first frame and the end of the parts between changes of a sound."""
    end = len(features)
    edges = [0, *sound_changes(features.reshape(end, -1), CHANGE_DEPTH), end]
    for first, stop in combinations(edges, 2):
        part = max(first - PART_MARGIN_FRAMES, 0), min(stop + PART_MARGIN_FRAMES, end)
        if part[1] - part[0] <= end - MIN_BESIDE_FRAMES:
            yield part


def sound_changes(values: Floats, depth: int) -> list[int]:
    """Return the frames where a sound changes most: its spectrum has another mean and variance."""
    count = np.arange(MIN_BESIDE_FRAMES, len(values) - MIN_BESIDE_FRAMES + 1, CHANGE_STEP_FRAMES)
    if depth == 0 or not len(count):
        return []
    sums = np.cumsum([values, values**2], axis=1)

    def spread(total: Floats, frames: Ints) -> Floats:
        """Return the logarithms of the variances of parts, by their sums, times their frames."""
        mean, power = total / frames[:, None]
        logs: Floats = np.log(power - mean**2 + MIN_VARIANCE).sum(axis=1)
        return frames * logs

    before, whole = sums[:, count - 1], sums[:, -1:]
    cost = spread(before, count) + spread(whole - before, len(values) - count)
    at = int(count[cost.argmin()])
    later = [at + one for one in sound_changes(values[at:], depth - 1)]
    return [*sound_changes(values[:at], depth - 1), at, *later]


def _alone(
    models: "Models",
    sound: PreparedSound,
    words: Sequence[Pronunciations],
    part: tuple[int, int],
    end: int,
) -> FoundLine:
    """Search for words in a part of a sound; the rest is other sound."""
    # the sound around the words of a part is not theirs
    found = _found(models, sound.part(*part), words, margin=0)
    return _placed(_chosen(found, PART_LOGIT)._replace(moved=None), part, end)


def _chosen(found: FoundLine, logit: float) -> FoundLine:
    """Return a try with less confidence, as it is one of several.

    Without a word, or in doubt, it is nothing.
    """
    left_out = any(one.phone == OUTSIDE != one.word for one in found.heard)
    if left_out or found.sure < DOUBTFUL:
        return FoundLine([], 0.0)
    odds = found.sure / (1 - found.sure + 1e-9) * exp(logit)
    return found._replace(sure=odds / (1 + odds))


def laid(
    models: "Models", features: HeardFrames, words: Sequence[Pronunciations]
) -> list[HeardPhoneme] | None:
    """Align words in short windows, and again in anchored ones if these lose the text or a word."""
    heard = lay(models.model, features, words)
    sure = line_confidence(heard) if heard else 0.0
    # where a short window stayed behind the voice, the next one has no time for the words between
    lost = any(one.phone == OUTSIDE != one.word for one in heard or ())
    if len(features) <= WINDOW_FRAMES or (sure >= DOUBTFUL and not lost):
        return heard
    again = lay(models.model, features, words, anchored=True)
    return again if again and line_confidence(again) > sure else heard
