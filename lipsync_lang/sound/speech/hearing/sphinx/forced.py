"""Forced alignment of words to a sound.

The sound is processed in windows, so that cost is linear in its length. Each window is decoded by
the most likely path through the words ahead, with optional pauses. Words that end some seconds
before the window's end are kept, and the next window starts there. Kept phonemes are aligned
again with their actual neighbours as context.

The path of a window may end in any word. Where the model hears badly, as in languages that are not
its own, such a path stays behind the voice: other sound is likelier there than the right phonemes.
An anchored window ends in a word that the pace of the remaining text allows, and keeps its first
half; it takes twice the time.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats, Singles
from lipsync_lang.sound.speech.hearing.progress import tell
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import (
    OUTSIDE,
    STATES,
    AcousticModel,
    FrameBests,
    Listening,
    PhoneContext,
    WordPosition,
)
from lipsync_lang.sound.speech.hearing.sphinx.features import EVEN_STEPS, HeardFrames

SOUND_START = -1
"""Predecessor of a phoneme at the start of the sound."""

NEVER = np.float32(-1e30)

ACOUSTIC_SCALE = 0.1
"""Weight of a frame's log likelihood where paths are weighed against each other.

Frames that overlap and belong to one sound are no independent evidence.
"""

NEAR_FRAMES = 10
"""Most frames between a boundary and that of the likeliest path."""

WINDOW_FRAMES = 1600
"""Window length in frames: 16 s."""

ANCHORED_FRAMES = 4000
"""Length of an anchored window in frames: 40 s."""

PACE_TOLERANCE = 0.25
"""Greatest relative difference of the pace in an anchored window from that of the rest."""

OVERLAP_FRAMES = 300
"""Frames at the end of a window that are decoded again in the next."""

OTHER_SOUND_LOG = -5.0
"""Log likelihood penalty per frame of other sound, relative to the likeliest phoneme."""

ENTER_OTHER_LOG = -20.0
"""Log score for entering other sound; it keeps badly spoken phonemes in their word."""

SKIP_WORD_LOG = -160.0
"""Log score for leaving a word out, which is then tried as spoken."""

MISSING_WORD_LOG, MISSING_PHONE_LOG = -140.0, -35.0
"""Log scores for leaving a word out that has no time: the first, or the second for each phoneme."""

HURRIED_WORD_FRAMES = 4.0
"""Frames per phoneme below which a word may have no time: each phoneme has three states."""

ROOM_FRAMES = 1.6
"""Frames of other sound per phoneme of a word that leave it time."""

ROOM_SHARE = 0.7
"""Share of a word's usual length that leaves it time, if both neighbours have theirs."""

MANY_WORDS = 5
"""Number of words left out in a window from which they stay so, if they leave no sound."""

MIN_OTHER_SHARE = 0.1
"""Share of sound without text from which its cepstra are kept out of their mean."""

FASTEST_FRAMES = 4
"""Frames per phoneme of the fastest speech over a whole window."""

MEAN_MARGIN_FRAMES = 30
"""Frames before and after words whose cepstra are in that mean."""

Pronunciations = Sequence[tuple[int, ...]]
"""Pronunciations of a word, each a tuple of phoneme numbers."""


class SureWord(tuple[tuple[int, ...], ...]):
    """Pronunciations of a word that is surely spoken, so that it is never left out."""

    __slots__ = ()


class Run(NamedTuple):
    """A phoneme on the path: node number, first frame, and first frame after it."""

    phone: int
    first: int
    stop: int


def likeliest_way(
    scores: Singles,
    stay: Floats,
    before: Sequence[Sequence[int]],
    ends: Sequence[int] | None = None,
    turns: Floats | None = None,
) -> list[Run] | None:
    """Find the likeliest path with every phoneme passing through all its states (Viterbi).

    Parameters
    ----------
    scores : (T, P, `STATES`) log likelihood of each frame in each state
    stay : (P, `STATES`) log probability of staying in a state for another frame
    before : permitted predecessors of each phoneme; `SOUND_START` for the start of the sound
    ends : permitted last phonemes; None for any
    turns : (P,) log score added on entering a phoneme; zero by default

    Returns
    -------
    Phonemes in order, from frame 0 to T; None if every path is longer than the sound
    """
    count, phones = scores.shape[:2]
    held = stay.astype(np.float32)
    # log(1 - exp(stay)), without the loss of digits where `stay` is near 0.
    left = np.log(-np.expm1(stay)).astype(np.float32)
    entered = np.zeros(phones, np.float32) if turns is None else turns.astype(np.float32)
    starts = [number for number, others in enumerate(before) if SOUND_START in others]
    # Rows of predecessors, filled up with the number of phonemes.
    follows = np.full((phones, max(map(len, before))), phones)
    for number, others in enumerate(before):
        real = [other for other in others if other != SOUND_START]
        follows[number, : len(real)] = real
    now = np.full((phones, STATES), NEVER, np.float32)
    now[starts, 0] = scores[0, starts, 0] + entered[starts]
    # One place more: phonemes with few predecessors are filled up with a number that never wins.
    out = np.full(phones + 1, NEVER, np.float32)
    come = np.empty_like(now)
    came = np.zeros((count, phones), np.int32)
    moved = np.zeros((count, phones, STATES), bool)
    rows = np.arange(phones)
    for frame in range(1, count):
        np.add(now[:, -1], left[:, -1], out=out[:phones])
        ways = out[follows]
        choice = ways.argmax(axis=1)
        came[frame] = follows[rows, choice]
        np.add(ways[rows, choice], entered, out=come[:, 0])
        np.add(now[:, :-1], left[:, :-1], out=come[:, 1:])
        now += held
        # Staying wins a tie, so that a phoneme lasts as long as it is no worse.
        np.greater(come, now, out=moved[frame])
        np.maximum(come, now, out=now)
        now += scores[frame]
    if ends is None:
        phone, state = divmod(int(now.argmax()), STATES)
    else:
        phone, state = max(ends, key=lambda number: float(now[number, -1])), STATES - 1
    # Sums of real scores stay far above half of this; below it, no path reaches the end.
    if now[phone, state] <= NEVER / 2:
        return None
    return _traced(moved, came, phone, state)


def _traced(
    moved: npt.NDArray[np.bool_], came: npt.NDArray[np.int32], phone: int, state: int
) -> list[Run]:
    """Return the path that ends in a state, from each frame's entered states and predecessors."""
    runs: list[Run] = []
    stop = len(moved)
    # Backwards, from the last state to the one that entered it.
    for frame in range(stop - 1, 0, -1):
        if moved[frame, phone, state]:
            if state:
                state -= 1
            else:
                runs.append(Run(phone, frame, stop))
                stop, phone, state = frame, int(came[frame, phone]), STATES - 1
    return [*runs, Run(phone, 0, stop)][::-1]


def median_starts(scores: Singles, stay: Floats, runs: Sequence[Run]) -> Floats:
    """Return the median start of each phoneme over all paths near the likeliest one.

    The likeliest path alone jumps where two places of a boundary are nearly as likely. The median
    has the least expected error, and lies between frames.

    Parameters
    ----------
    scores : (T, P, `STATES`) log likelihood of each frame in each state of the P runs
    stay : (P, `STATES`) log probability of staying in a state for another frame
    runs : the likeliest path, from frame 0 to T

    Returns
    -------
    (P,) starts in frames, ascending
    """
    count, phones = scores.shape[:2]
    frames = np.arange(count)[:, None]
    firsts, stops = np.array([[run.first, run.stop] for run in runs]).T
    near = (frames >= firsts - NEAR_FRAMES) & (frames < stops + NEAR_FRAMES)
    likely = np.where(near[..., None], scores * ACOUSTIC_SCALE, NEVER).reshape(count, -1)
    held = stay.ravel()
    left = np.log(-np.expm1(held))
    # Log probabilities of all paths to a state, and from it on. The path so far ends in `[1:]`.
    past = np.full((count, 1 + len(held)), float(NEVER))
    past[0, 1] = likely[0, 0]
    for frame in range(1, count):
        before = past[frame - 1]
        come = before[:-1] + np.append(NEVER, left[:-1])
        past[frame, 1:] = np.logaddexp(before[1:] + held, come) + likely[frame]
    rest = np.full((count, len(held) + 1), float(NEVER))
    rest[-1, -2] = 0.0
    for frame in range(count - 2, -1, -1):
        after = rest[frame + 1, :-1] + likely[frame + 1]
        rest[frame, :-1] = np.logaddexp(after + held, np.append(after[1:] + left[:-1], NEVER))
    whole = past[:, 1:] + rest[:, :-1]
    share = np.exp(whole - whole[-1, -1]).reshape(count, phones, STATES).sum(axis=2)
    # The share of the paths that are in a phoneme or a later one grows from frame to frame.
    begun = np.cumsum(share[:, ::-1], axis=1)[:, ::-1]
    middles = np.arange(count) + 0.5
    later = [np.interp(0.5, begun[:, n], middles) for n in range(1, phones)]
    return np.rint(np.array([0.0, *later]) * EVEN_STEPS) / EVEN_STEPS


class HeardPhoneme(NamedTuple):
    """A phoneme, a pause or other sound, with its frames.

    `word` is the word number, or `OUTSIDE` between words; `phone` is the phoneme number in
    the model, or `OUTSIDE` for other sound, which stands for a word that is left out where it has a
    word number. `fit` is the mean log likelihood ratio per frame to the likeliest
    context-independent phoneme; `noise` is that of silence and noises, which is low in speech.
    The median start over all likely paths is `late` frames after `first`.
    """

    word: int
    phone: int
    first: int
    stop: int
    fit: float
    noise: float = -10.0
    late: float = 0.0


class Node(NamedTuple):
    """A candidate phoneme of a word, or a candidate pause."""

    word: int
    phone: int
    place: WordPosition


@dataclass
class Graph:
    """Graph of permitted phoneme sequences: nodes with their contexts and predecessors.

    With `words_alone`, there is no other sound in the pauses.
    """

    model: AcousticModel
    words_alone: bool = False
    nodes: list[Node] = field(default_factory=list)
    contexts: list[PhoneContext] = field(default_factory=list)
    before: list[list[int]] = field(default_factory=list)

    def add(self, node: Node, left: int, right: int, before: Sequence[int]) -> int:
        """Add a phoneme in context and return its node number."""
        self.nodes.append(node)
        self.contexts.append(_context(self.model, node, left, right))
        self.before.append([*before])
        return len(self.nodes) - 1

    def pause(self, before: Sequence[int]) -> list[int]:
        """Add optional silence and other sound, alternating."""
        silence = self.model.silence
        quiet = self.add(Node(OUTSIDE, silence, WordPosition.INSIDE), silence, silence, before)
        if self.words_alone:
            return [quiet]
        # Silence and other sound follow each other in any order: each may precede the other.
        other = Node(OUTSIDE, OUTSIDE, WordPosition.INSIDE)
        loud = self.add(other, silence, silence, [*before, quiet])
        self.before[quiet].append(loud)
        return [quiet, loud]

    def word(
        self, number: int, ways: Pronunciations, left: int, right: int, before: Sequence[int]
    ) -> list[int]:
        """Add a word's pronunciations in context and return their end nodes."""
        ends: list[int] = []
        for way in ways:
            last: Sequence[int] = before
            around = (left, *way, right)
            inside = [WordPosition.INSIDE] * (len(way) - 2)
            places = [WordPosition.BEGIN, *inside, WordPosition.END]
            for at, phone in enumerate(way):
                node = Node(number, phone, places[at] if len(way) > 1 else WordPosition.ALONE)
                last = [self.add(node, around[at], around[at + 2], last)]
            ends += last
        return ends


def _context(model: AcousticModel, node: Node, left: int, right: int) -> PhoneContext:
    if OUTSIDE in (node.word, node.phone):
        return model.silence, OUTSIDE, OUTSIDE, None
    return node.phone, left, right, node.place


def lay(
    model: AcousticModel,
    features: HeardFrames,
    words: Sequence[Pronunciations],
    *,
    anchored: bool = False,
) -> list[HeardPhoneme] | None:
    """Align words to a sound.

    Parameters
    ----------
    model : acoustic model
    features : (T, 3, 13) of the sound
    words : pronunciations in spoken order
    anchored : whether the pace of the text limits in which word a window ends

    Returns
    -------
    Phonemes from frame 0 to T, with every word included, as other sound where it is left out;
    None if the sound is too short, or if too many words are left for its last window
    """
    heard = _lay(model, features, words, anchored=anchored)
    if heard is None:
        return None
    own = centred(features, heard)
    return heard if own is features else _lay(model, own, words, anchored=anchored)


def centred(features: HeardFrames, heard: Sequence[HeardPhoneme]) -> HeardFrames:
    """Return features less the mean of the voice's own frames, where music or noise is beside it.

    They are the same object where there is little other sound.
    """
    foreign = sum(one.stop - one.first for one in heard if one.phone == OUTSIDE)
    own = np.zeros(len(features), bool)
    for one in heard:
        if OUTSIDE not in (one.word, one.phone):
            own[max(one.first - MEAN_MARGIN_FRAMES, 0) : one.stop + MEAN_MARGIN_FRAMES] = True
    for one in heard:
        own[one.first : one.stop] &= one.phone != OUTSIDE
    if foreign < MIN_OTHER_SHARE * len(features) or not own.any():
        return features
    moved = features.wide.copy()
    moved[:, 0] -= features.first_stream()[own].mean(axis=0)
    return replace(features, wide=moved)


def _lay(
    model: AcousticModel, features: HeardFrames, words: Sequence[Pronunciations], *, anchored: bool
) -> list[HeardPhoneme] | None:
    """Align words to a sound, window by window."""
    heard: list[HeardPhoneme] = []
    at = done = 0
    while at < len(features):
        tell(at, len(features))
        rest = replace(features, wide=features.wide[at:])
        found = _window(model, rest, words, done, anchored=anchored)
        if found is None:
            return None
        heard += [h._replace(first=h.first + at, stop=h.stop + at) for h in found]
        # A window may end in a pause, whose number is below that of every word.
        done = max(done, *(h.word + 1 for h in found))
        at = heard[-1].stop
    return heard


def _reach(
    features: HeardFrames, words: Sequence[Pronunciations], done: int, *, anchored: bool
) -> tuple[int, int, int]:
    """Return the frames of the next window, the first word that it may end in, and its limit."""
    window = min(len(features), ANCHORED_FRAMES if anchored else WINDOW_FRAMES)
    last = window == len(features)
    if not anchored or last or done == len(words):
        # Each state takes a frame at least. No window but the last has more words than fit at the
        # fastest pace, and the search keeps only those that end before its overlap.
        pace = STATES if last else FASTEST_FRAMES
        ahead = words[done : done + window // pace]
        shortest = np.cumsum([pace * min(map(len, ways)) for ways in ahead])
        return window, done, done + int(np.searchsorted(shortest, window, side="right"))
    # The loudness of a frame is its first cepstrum, less the mean: pauses do not count.
    loud = features.first_stream()[:, 0] > 0
    counts = np.cumsum([len(ways[0]) for ways in words[done:]])
    expected = counts[-1] * loud[:window].sum() / max(loud.sum(), 1)
    limits = expected * np.array([1 - PACE_TOLERANCE, 1 + PACE_TOLERANCE])
    near, far = (done + np.searchsorted(counts, limits)).tolist()
    return window, min(near, len(words) - 1), min(far + 1, len(words))


def _window(
    model: AcousticModel,
    features: HeardFrames,
    words: Sequence[Pronunciations],
    done: int,
    *,
    anchored: bool,
) -> list[HeardPhoneme] | None:
    """Return the kept path of the window at the start of a sound, with earlier words done."""
    window, near, stop = _reach(features, words, done, anchored=anchored)
    last = window == len(features)
    if last and stop < len(words):
        return None
    sound = Listening(model, features[:window])
    graph = Graph(model, features.words_alone)
    before: list[int] = [SOUND_START]
    for number in range(done, stop):
        # The context of a word's edges is the first pronunciation of its neighbours: which one is
        # said is not known yet. `_again` aligns with the real ones.
        left = words[number - 1][0][-1] if number > done else model.silence
        right = words[number + 1][0][0] if number + 1 < stop else model.silence
        before = [*before, *graph.pause(before)]
        spoken = graph.word(number, words[number], left, right, before)
        # Other sound in place of a word: the word is left out, if it proves to have no time.
        left_out = Node(number, OUTSIDE, WordPosition.ALONE)
        before = [*spoken, graph.add(left_out, model.silence, model.silence, before)]
    ends: Sequence[int] | None = None
    if last:
        ends = [*(n for n in before if n != SOUND_START), *graph.pause(before)]
    elif anchored and near < stop:
        ends = range([node.word for node in graph.nodes].index(near), len(graph.nodes))
    scores = sound.scores([*model.alone, *model.phones(graph.contexts)])
    alone, scores = np.split(scores, [len(model.alone)], axis=1)
    loop = FrameBests.of(sound, alone)
    decoded = partial(_likeliest, model, scores, loop, graph.nodes, graph.before, ends)
    if not (way := _truest_way(graph, words, range(done, stop), decoded)):
        return None
    del scores, decoded  # the path has fewer phonemes
    if not last:
        overlap = window // 2 if anchored else OVERLAP_FRAMES
        way = _kept(way, graph.nodes, window - overlap)
    return _again(sound, loop, [(graph.nodes[run.phone], run) for run in way])


def _likeliest(  # noqa: PLR0913, PLR0917 the scores, the graph and options
    model: AcousticModel,
    scores: Singles,
    loop: FrameBests,
    nodes: Sequence[Node],
    before: Sequence[Sequence[int]],
    ends: Sequence[int] | None,
    spoken: AbstractSet[int] = frozenset(),
    prices: float | Floats = 0.0,
) -> list[Run]:
    other = np.array([node.phone == OUTSIDE for node in nodes])
    # Other sound is as likely as the best phoneme less a penalty: it wins only where no phoneme of
    # the text is near the best.
    scores[:, other] = (loop.speech + np.float32(OTHER_SOUND_LOG))[:, None, None]
    names = [model.silence if node.phone == OUTSIDE else node.phone for node in nodes]
    quiet = np.equal(names, model.silence) & ~other
    scores[:, quiet] = np.minimum(scores[:, quiet], loop.pause[:, None, None])
    skipped = np.array([node.word != OUTSIDE for node in nodes]) & other
    entered = np.where(skipped, prices, np.where(other, ENTER_OTHER_LOG, 0.0))
    entered[[node.word in spoken and node.phone == OUTSIDE for node in nodes]] = -np.inf
    return likeliest_way(scores, model.stay[names], before, ends, entered) or []


def _truest_way(
    graph: Graph,
    words: Sequence[Pronunciations],
    numbers: range,
    decoded: Callable[[AbstractSet[int], float | Floats], list[Run]],
) -> list[Run]:
    """Return the likeliest path that leaves words out only where their time is missing.

    `decoded` returns the likeliest path in which some words are spoken, with the price of others;
    the path is empty if every one is longer than the sound.
    """
    nodes, every = graph.nodes, frozenset(numbers)
    sure = frozenset(number for number in numbers if isinstance(words[number], SureWord))
    way = decoded(sure, SKIP_WORD_LOG)
    skipped = _skipped(nodes, way)
    said = decoded(every, 0.0) if skipped else way
    # Where many words have no sound, the text or its order is another one, which others find.
    if not said or (len(skipped) >= MANY_WORDS and _roomless(words, skipped)):
        return way
    if not (hurried := _hurried(graph.model, nodes, said) - sure):
        return said
    counts = np.array([len(words[node.word][0]) for node in nodes])
    prices = np.minimum(MISSING_WORD_LOG, MISSING_PHONE_LOG * counts)
    rooms = _skipped(nodes, decoded(every - hurried, prices))
    missing = {word for word, room in rooms.items() if _roomless(words, {word: room})}
    return decoded(every - missing, prices) or said if missing else said


def _skipped(nodes: Sequence[Node], way: Sequence[Run]) -> dict[int, int]:
    """Return the words that a path leaves out, with the frames of other sound in their places.

    These are between the words before and after it, and beside those: a short neighbour moves.
    """
    rooms: dict[int, int] = {}
    others: Counter[int] = Counter()
    last = OUTSIDE
    for run in way:
        word, phone, _ = nodes[run.phone]
        last = max(last, word)
        if phone == OUTSIDE != word:
            rooms[word] = run.stop - run.first
        elif phone == OUTSIDE:
            others[last] += run.stop - run.first
    return {
        word: room + sum(others[word + by] for by in range(-2, 2)) for word, room in rooms.items()
    }


def _roomless(words: Sequence[Pronunciations], rooms: Mapping[int, int]) -> bool:
    """Return True if the frames of other sound in the places of words are too few for them.

    Where they are many, somebody speaks: that sound is the words, badly heard.
    """
    phones = sum(len(words[word][0]) for word in rooms)
    return sum(rooms.values()) < ROOM_FRAMES * phones


def _hurried(model: AcousticModel, nodes: Sequence[Node], way: Sequence[Run]) -> set[int]:
    """Return the words that have no time in a path with every word.

    Their phonemes are as short as can be, and neighbours of usual length fill their sound.
    """
    said = [(nodes[run.phone], run) for run in way if OUTSIDE not in nodes[run.phone][:2]]
    # A place more at both ends, for neighbours that are not there.
    places = np.array([node.word + 1 for node, _ in said], int)
    lengths = [run.stop - run.first for _, run in said]
    usual = (1 / -np.expm1(model.stay)).sum(axis=1)[[node.phone for node, _ in said]]
    size = places.max(initial=0) + 2
    frames, due = (np.bincount(places, some, size) for some in (lengths, usual))
    short = frames < HURRIED_WORD_FRAMES * np.bincount(places, minlength=size)
    due = due * frames[~short].sum() / max(due[~short].sum(), 1e-9)
    spare = frames - due
    room = frames[1:-1] + spare[:-2] + spare[2:]
    return {*np.flatnonzero(short[1:-1] & (room < ROOM_SHARE * due[1:-1])).tolist()}


def _kept(way: Sequence[Run], nodes: Sequence[Node], limit: int) -> list[Run]:
    """Return the start of a path, up to the last word or pause that ends before a frame.

    Without such an end: a long pause cut short, or the only word.
    """
    words = [nodes[run.phone].word for run in way]
    ends = [OUTSIDE in pair or pair[0] != pair[1] for pair in pairwise(words)]
    # A cut lies between two words or beside a pause, never within a word.
    cuts = [n for n, end in enumerate(ends, 1) if end]
    kept = max((n for n in cuts if way[n - 1].stop <= limit), default=0)
    if kept:
        return [*way[:kept]]
    if words[0] == OUTSIDE:
        return [way[0]._replace(stop=limit)]
    return [*way[: min(cuts, default=len(way))]]


def _again(
    sound: Listening, loop: FrameBests, way: Sequence[tuple[Node, Run]]
) -> list[HeardPhoneme]:
    """Align phonemes again, each with its actual neighbours as context."""
    model, stop = sound.model, way[-1][1].stop
    nodes = [node for node, _ in way]
    around = [model.silence if node.phone == OUTSIDE else node.phone for node in nodes]
    around = [model.silence, *around, model.silence]
    contexts = [_context(model, node, around[n], around[n + 2]) for n, node in enumerate(nodes)]
    scores = sound.scores(model.phones(contexts))[:stop]
    before = [[n - 1] for n in range(len(nodes))]
    loop = FrameBests(*(one[:stop] for one in loop))
    chain = _likeliest(model, scores, loop, nodes, before, [len(nodes) - 1])
    # Without a path in the real contexts, the frames of the first search stay.
    runs = chain or [run._replace(phone=n) for n, (_, run) in enumerate(way)]
    stay = model.stay[around[1:-1]]
    starts = median_starts(scores, stay, runs) if chain else [run.first for run in runs]
    heard = []
    for node, run, start in zip(nodes, runs, starts, strict=True):
        span = slice(run.first, run.stop)
        fit, noise = (
            float((here - loop.speech[span]).mean(dtype=np.float64))
            for here in (scores[span, run.phone].max(axis=1), loop.quiet[span])
        )
        late = float(start) - run.first
        heard.append(HeardPhoneme(node.word, node.phone, run.first, run.stop, fit, noise, late))
    return heard
