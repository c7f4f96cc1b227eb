"""CMU Sphinx acoustic models, read from their folder: phonetically tied mixtures.

Each phoneme has a codebook of Gaussians in three streams; each state has mixture weights for the
codebook. The states of a phoneme depend on its neighbours and its position in the word.
"""

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang.arrays import Floats, Ints, Singles
from lipsync_lang.errors import SpeechError


class WordPosition(IntEnum):
    """Position of a phoneme in its word."""

    INSIDE = 0
    BEGIN = 1
    END = 2
    ALONE = 3


STATES = 3
"""Number of states per phoneme, in sequence."""

STREAMS = 3
"""Number of feature streams, each with its own Gaussians."""

WEIGHT_STEP = 1024 * np.log(1.0001)
"""Natural logarithm per step of a quantised weight."""

MAX_BLOCK_CELLS = 200_000
"""Row block size of the matrix product."""

OUTSIDE = -1
"""Number in place of a phoneme or word, for none."""

VARIANCE_FLOOR = 1e-4
"""Variance floor."""

FAINTEST_LOG = -40.0
"""Log floor of a Gaussian relative to the nearest: negligible below, and slow to add."""


class Phone(NamedTuple):
    """A phoneme in context: its codebook and states."""

    book: int
    states: tuple[int, ...]


PhoneContext = tuple[int, int, int, WordPosition | None]
"""A phoneme, the ones before and after it, and its position; None outside words: no context."""


@dataclass(frozen=True, eq=False)
class AcousticModel:
    """Emission and transition parameters of every phoneme state.

    Parameters
    ----------
    names : phoneme names by number
    silence : the number of silence
    fillers : numbers of non-speech phonemes
    alone : context-independent phonemes by number
    keys : ascending, one for each phoneme in context (`_key`)
    rows : state row of each key
    states : state numbers, (rows, `STATES`)
    stay : (phonemes, `STATES`) log probability of staying in a state for another frame
    gaussians : (books, 3, 27, Gaussians) factors of a frame's squares, of its values, and of
        1; their sum is the log likelihood of the frame
    weights : (3, Gaussians, states) mixture weights
    """

    names: tuple[str, ...]
    silence: int
    fillers: frozenset[int]
    alone: tuple[Phone, ...]
    keys: Ints
    rows: Ints
    states: Ints
    stay: Floats
    gaussians: Singles
    weights: Singles

    def phones(self, contexts: Iterable[PhoneContext]) -> list[Phone]:
        """Return phonemes in context; each is the closest match in the model."""
        return [self._phone(*context) for context in contexts]

    def _phone(self, here: int, left: int, right: int, place: WordPosition | None) -> Phone:
        if place is None:
            return self.alone[here]
        # Models are trained on the contexts of their corpus alone. Silence is the neighbour in
        # most of them, so it comes before a phoneme without any context.
        for beside in ((left, right), (self.silence, right), (left, self.silence)):
            for where in dict.fromkeys((place, *WordPosition)):
                key = _key(here, *beside, where)
                at = int(self.keys.searchsorted(key))
                if at < len(self.keys) and self.keys[at] == key:
                    return Phone(here, tuple(self.states[self.rows[at]].tolist()))
        return self.alone[here]


@dataclass(frozen=True, eq=False)
class Listening:
    """Log likelihoods of a sound under a model.

    Parameters
    ----------
    model : acoustic model
    features : (T, 3, 13) of the sound
    """

    model: AcousticModel
    features: Floats
    _near: dict[tuple[int, int], tuple[Singles, Singles]] = field(
        init=False, repr=False, default_factory=dict
    )

    def scores(self, phones: Sequence[Phone]) -> Singles:
        """Return the log likelihood of each frame in each state of the given phonemes.

        Parameters
        ----------
        phones : P phonemes

        Returns
        -------
        (T, P, `STATES`) natural logarithms
        """
        books: dict[int, list[int]] = {}
        for number, phone in enumerate(phones):
            books.setdefault(phone.book, []).append(number)
        found = np.empty((len(self.features), len(phones), STATES), np.float32)
        for book, numbers in books.items():
            states = np.array([phones[number].states for number in numbers])
            wanted, back = np.unique(states, return_inverse=True)
            heard = np.zeros((len(self.features), len(wanted)), np.float32)
            for stream in range(STREAMS):
                # log sum exp, with the nearest Gaussian taken out so that no exponent underflows
                shares, most = self._shares(book, stream)
                weights = self.model.weights[stream][:, wanted]
                heard += np.log(_product(shares, weights)) + most
            found[:, numbers] = heard[:, back.reshape(states.shape)]
        return found

    def _shares(self, book: int, stream: int) -> tuple[Singles, Singles]:
        """Return Gaussian likelihoods relative to the nearest, and the log likelihood of that."""
        key = (book, stream)
        if key not in self._near:
            here = self.features[:, stream]
            terms = np.hstack([here * here, here, np.ones((len(here), 1))]).astype(np.float32)
            near = _product(terms, self.model.gaussians[key])
            most = near.max(axis=1, keepdims=True)
            near -= most
            np.maximum(near, FAINTEST_LOG, out=near)
            self._near[key] = np.exp(near, out=near), most
        return self._near[key]


def _product(many: Singles, few: Singles) -> Singles:
    """Multiply a long matrix by a small one, in blocks of rows.

    A single product would start threads whose synchronisation costs more than the work.
    """
    # BLAS multiplies a stack of small matrices in this thread; only the rest is left over.
    rows = max(MAX_BLOCK_CELLS // few.size, 1)
    whole = len(many) // rows * rows
    found = np.empty((len(many), few.shape[1]), np.float32)
    pieces = many[:whole].reshape(-1, rows, many.shape[1])
    np.matmul(pieces, few, out=found[:whole].reshape(-1, rows, few.shape[1]))
    np.matmul(many[whole:], few, out=found[whole:])
    return found


def _key(here: Any, left: Any, right: Any, place: Any) -> Any:
    """Return the integer key of a phoneme in context; vectorised."""
    return ((here * 256 + left) * 256 + right) * 256 + place


@cache
def read_model(folder: Path) -> AcousticModel:
    """Read the acoustic model in a folder.

    A file that is missing, truncated or of another kind is a `SpeechError`.
    """
    try:
        return _read(folder)
    except OSError as error:
        raise SpeechError(f"{folder}: no acoustic model: {error.strerror or error}") from None
    except (struct.error, ValueError, IndexError, KeyError) as error:
        raise SpeechError(
            f"{folder}: not an acoustic model of phonetically tied mixtures ({error}); "
            "install it again, or name another"
        ) from None


def _read(folder: Path) -> AcousticModel:
    parameters = []
    for name in ("means", "variances"):  # each (books, streams, Gaussians, values)
        content, at = _body(folder / name)
        books, streams, count = struct.unpack_from("<3i", content, at)
        lengths = struct.unpack_from(f"<{streams}i", content, at + 12)
        if streams != STREAMS or len(set(lengths)) != 1:
            raise ValueError(f"{name} has streams of another form")
        size = books * streams * count * lengths[0]
        values = np.frombuffer(content, "<f4", size, at + 16 + 4 * streams)
        parameters.append(values.reshape(books, streams, count, lengths[0]).astype(np.float64))
    means, variances = parameters
    precision = 1 / np.maximum(variances, VARIANCE_FLOOR)
    # A diagonal Gaussian: log N(x) = sum(log(p / 2 pi) - p (x - m)^2) / 2, with p for 1 / variance,
    # as factors of x^2, x and 1, so that one matrix product has all frames.
    constant = (np.log(precision / (2 * np.pi)) - precision * means**2).sum(axis=-1) / 2
    factors = [-precision / 2, precision * means, constant[..., None]]
    gaussians = np.concatenate(factors, axis=-1).swapaxes(-1, -2)
    names, silence, fillers, alone, keys, rows, states = _definitions(folder / "mdef")
    weights = _weights(folder / "sendump", means.shape[2], int(states.max()) + 1)
    content, at = _body(folder / "transition_matrices")
    # The length of the table is the last of the four header numbers.
    (size,) = struct.unpack_from("<i", content, at + 12)
    moves = np.frombuffer(content, "<f4", size, at + 16).astype(np.float64)
    moves = moves.reshape(-1, STATES, STATES + 1)
    # The diagonal has the moves from a state to itself; rows of some models do not sum to 1.
    staying = np.einsum("pss->ps", moves[:, :, :STATES]) / moves.sum(axis=-1)
    if not len(names) == len(means) == len(staying):
        raise ValueError("not one codebook per phoneme")
    return AcousticModel(
        names, silence, fillers, alone, keys, rows, states,
        np.log(staying), gaussians.astype(np.float32), weights,
    )  # fmt: skip


def _definitions(
    path: Path,
) -> tuple[tuple[str, ...], int, frozenset[int], tuple[Phone, ...], Ints, Ints, Ints]:
    """Read the states of each phoneme in context: the first seven fields of `AcousticModel`."""
    content = path.read_bytes()
    if content[:4] != b"BMDF":
        raise ValueError(f"{path.name} has another form")
    (skipped,) = struct.unpack_from("<i", content, 8)
    at = 12 + skipped
    head = struct.unpack_from("<10i", content, at)
    simple, count, length, _, _, _, rows, _, nodes, silence = head
    if length != STATES:
        raise ValueError(f"{length} states per phoneme instead of {STATES}")
    at += 40
    names = content[at:].split(b"\0", simple)[:simple]
    # Names are padded to four bytes; the tree of contexts after them is not needed.
    at += -(-sum(len(name) + 1 for name in names) // 4) * 4 + nodes * 8
    entry = np.dtype([("row", "<i4"), ("moves", "<i4"), ("where", "u1", 4)])
    entries = np.frombuffer(content, entry, count, at)
    table = np.frombuffer(content, "<u2", rows * STATES, at + count * entry.itemsize + 4)
    where = entries["where"].astype(np.int64)
    keys = _key(where[:, 1], where[:, 2], where[:, 3], where[:, 0])
    states = table.reshape(rows, STATES).astype(np.int64)
    # The first entries have no context. The others are sorted for a search by halves.
    order = simple + np.argsort(keys[simple:])
    return (
        tuple(name.decode() for name in names),
        silence,
        frozenset(np.flatnonzero(where[:simple, 0]).tolist()),
        tuple(
            Phone(n, tuple(row)) for n, row in enumerate(states[entries["row"][:simple]].tolist())
        ),
        keys[order],
        entries["row"][order].astype(np.int64),
        states,
    )


def _body(path: Path) -> tuple[bytes, int]:
    """Return a file's content and the offset of its numbers."""
    content = path.read_bytes()
    # The mark of the byte order follows the head, which is text of any length.
    at = content.index(b"endhdr\n") + 7
    if struct.unpack_from("<I", content, at) != (0x11223344,):
        raise ValueError(f"{path.name} has another byte order")
    return content, at + 4


def _weights(path: Path, count: int, states: int) -> Singles:
    """Read quantised weights: (streams, Gaussians, states)."""
    content = path.read_bytes()
    at = 0
    strings: list[str] = []
    # Strings with their lengths come first. The list has no count: a length of 0 ends it.
    while (size := struct.unpack_from("<i", content, at)[0]) > 0:
        strings.append(content[at + 4 : at + 4 + size].rstrip(b"\0").decode())
        at += 4 + size
    at += 4
    if "cluster_count 0" not in strings:
        raise ValueError(f"{path.name} is clustered")
    rows, columns = struct.unpack_from("<2i", content, at)
    if rows != count or columns < states:
        raise ValueError(f"{path.name} does not fit the other files")
    # A byte is the logarithm of a weight, in negative steps.
    steps = np.frombuffer(content, "u1", STREAMS * rows * columns, at + 8)
    weights = np.exp(-WEIGHT_STEP * np.arange(256)).astype(np.float32)
    found: Singles = weights[steps.reshape(STREAMS, rows, columns)]
    return found
