"""Acoustic models of CMU Sphinx, read from their folder: phonetically tied mixtures.

Each phoneme has a codebook of Gaussians in three streams; each state weighs those of its phoneme.
Which states a phoneme has depends on its neighbours and on its place in the word.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import SpeechError

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Singles = npt.NDArray[np.float32]


class WordPosition(IntEnum):
    """Where in its word a phoneme stands."""

    INSIDE = 0
    BEGIN = 1
    END = 2
    ALONE = 3


STATES = 3
"""States of a phoneme, one after the other."""

STREAMS = 3
"""Streams of features, each with Gaussians of its own."""

STEP = 1024 * np.log(1.0001)
"""What one step of a quantised weight is, as a natural logarithm."""

SMALL = 200_000
"""Multiplications that are done at once."""

OUTSIDE = -1
"""The number of what is no phoneme, or no word."""

FLOOR = 1e-4
"""The least variance."""

FAINT = -40.0
"""A Gaussian this far below the nearest, as a logarithm, tells nothing; less is slow to add."""


class Phone(NamedTuple):
    """A phoneme beside its neighbours: the codebook that it uses, and its states."""

    book: int
    states: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class AcousticModel:
    """What every state of every phoneme sounds like.

    Parameters
    ----------
    names : the phonemes, by their numbers
    silence : the number of silence
    fillers : the numbers of phonemes that are no speech
    simple : the states of phonemes that mind no neighbours
    keys : rising, one for each phoneme beside its neighbours (`_key`)
    rows : for each of these, the row of its states
    states : the states that phonemes have: (rows, `STATES`)
    stay : (phonemes, `STATES`) logarithm of how likely a state lasts another frame
    gaussians : (books, 3, 27, Gaussians) the factors of a frame's squares, of its values, and of
        1, whose sum is the logarithm of how likely the frame is
    weights : (3, Gaussians, states) how much of each Gaussian is in each state
    """

    names: tuple[str, ...]
    silence: int
    fillers: frozenset[int]
    simple: tuple[tuple[int, ...], ...]
    keys: Ints
    rows: Ints
    states: Ints
    stay: Floats
    gaussians: Singles
    weights: Singles

    def alone(self, phone: int) -> Phone:
        """Return a phoneme that minds no neighbours."""
        return Phone(phone, self.simple[phone])

    def phone(self, here: int, left: int, right: int, place: WordPosition) -> Phone:
        """Return a phoneme beside its neighbours, or as near to that as the model has it."""
        for beside in ((left, right), (self.silence, right), (left, self.silence)):
            for where in dict.fromkeys((place, *WordPosition)):
                found = self._find(here, *beside, where)
                if found is not None:
                    return found
        return self.alone(here)

    def _find(self, here: int, left: int, right: int, place: WordPosition) -> Phone | None:
        key = _key(here, left, right, place)
        at = int(self.keys.searchsorted(key))
        if at == len(self.keys) or self.keys[at] != key:
            return None
        return Phone(here, tuple(self.states[self.rows[at]].tolist()))


@dataclass(frozen=True, eq=False)
class Listening:
    """A sound as a model hears it.

    Parameters
    ----------
    model : what phonemes sound like
    features : (T, 3, 13) of the sound
    """

    model: AcousticModel
    features: Floats
    _near: dict[tuple[int, int], tuple[Singles, Singles]] = field(
        init=False, repr=False, default_factory=dict
    )

    def __len__(self) -> int:
        return len(self.features)

    def scores(self, phones: Sequence[Phone]) -> Singles:
        """Return how likely each frame is in each state of some phonemes.

        Parameters
        ----------
        phones : P of them

        Returns
        -------
        (T, P, `STATES`) natural logarithms
        """
        books: dict[int, list[int]] = {}
        for number, phone in enumerate(phones):
            books.setdefault(phone.book, []).append(number)
        found = np.empty((len(self), len(phones), STATES), np.float32)
        for book, numbers in books.items():
            states = np.array([phones[number].states for number in numbers])
            wanted, back = np.unique(states, return_inverse=True)
            heard = sum(self._stream(book, stream, wanted) for stream in range(STREAMS))
            found[:, numbers] = np.asarray(heard)[:, back.reshape(states.shape)]
        return found

    def _stream(self, book: int, stream: int, states: Ints) -> Singles:
        """Return the scores of some states of a codebook in one stream: (T, states)."""
        shares, most = self._shares(book, stream)
        scores: Singles = np.log(_product(shares, self.model.weights[stream][:, states]))
        scores += most
        return scores

    def _shares(self, book: int, stream: int) -> tuple[Singles, Singles]:
        """Return how near each Gaussian is, the nearest being 1, and the logarithm of that."""
        key = (book, stream)
        if key not in self._near:
            here = self.features[:, stream]
            terms = np.hstack([here * here, here, np.ones((len(here), 1))]).astype(np.float32)
            near = _product(terms, self.model.gaussians[key])
            most = near.max(axis=1, keepdims=True)
            near -= most
            np.maximum(near, FAINT, out=near)
            self._near[key] = np.exp(near, out=near), most
        return self._near[key]


def _product(many: Singles, few: Singles) -> Singles:
    """Return the product of a long table and a small one, a few rows at a time.

    Whole, they would be shared out among threads, which wait for each other longer than they work.
    """
    rows = max(SMALL // few.size, 1)
    whole = len(many) // rows * rows
    found = np.empty((len(many), few.shape[1]), np.float32)
    pieces = many[:whole].reshape(-1, rows, many.shape[1])
    np.matmul(pieces, few, out=found[:whole].reshape(-1, rows, few.shape[1]))
    np.matmul(many[whole:], few, out=found[whole:])
    return found


def _key(here: Any, left: Any, right: Any, place: Any) -> Any:
    """Return the one number of a phoneme beside its neighbours, or of many."""
    return ((here * 256 + left) * 256 + right) * 256 + place


@cache
def read_model(folder: Path) -> AcousticModel:
    """Read the acoustic model in a folder.

    Raises
    ------
    SpeechError
        A file of it is missing, cut short or of another kind.
    """
    try:
        return _read(folder)
    except OSError as error:
        raise SpeechError(f"{folder}: no acoustic model: {error.strerror or error}") from None
    except (struct.error, ValueError, IndexError, KeyError) as error:
        raise SpeechError(
            f"{folder}: not an acoustic model of phonetically tied mixtures ({error}); "
            "install it anew, or name another"
        ) from None


def _read(folder: Path) -> AcousticModel:
    means, variances = (_gaussians(folder / name) for name in ("means", "variances"))
    precision = 1 / np.maximum(variances, FLOOR)
    constant = (np.log(precision / (2 * np.pi)) - precision * means**2).sum(axis=-1) / 2
    factors = [-precision / 2, precision * means, constant[..., None]]
    gaussians = np.concatenate(factors, axis=-1).swapaxes(-1, -2)
    found = _definitions(folder / "mdef")
    weights = _weights(folder / "sendump", means.shape[2], int(found.states.max()) + 1)
    moves = _table(folder / "transition_matrices").reshape(-1, STATES, STATES + 1)
    staying = np.einsum("pss->ps", moves[:, :, :STATES]) / moves.sum(axis=-1)
    if not len(found.names) == len(means) == len(staying):
        raise ValueError("not one codebook to a phoneme")
    return AcousticModel(*found, np.log(staying), gaussians.astype(np.float32), weights)


class _Definitions(NamedTuple):
    """Which states each phoneme has beside which neighbours, as in `AcousticModel`."""

    names: tuple[str, ...]
    silence: int
    fillers: frozenset[int]
    simple: tuple[tuple[int, ...], ...]
    keys: Ints
    rows: Ints
    states: Ints


def _definitions(path: Path) -> _Definitions:
    content = path.read_bytes()
    if content[:4] != b"BMDF":
        raise ValueError(f"{path.name} is of another form")
    (skipped,) = struct.unpack_from("<i", content, 8)
    at = 12 + skipped
    head = struct.unpack_from("<10i", content, at)
    simple, count, length, _, _, _, rows, _, nodes, silence = head
    if length != STATES:
        raise ValueError(f"{length} states to a phoneme instead of {STATES}")
    at += 40
    names = content[at:].split(b"\0", simple)[:simple]
    at += -(-sum(len(name) + 1 for name in names) // 4) * 4 + nodes * 8
    entry = np.dtype([("row", "<i4"), ("moves", "<i4"), ("where", "u1", 4)])
    entries = np.frombuffer(content, entry, count, at)
    table = np.frombuffer(content, "<u2", rows * STATES, at + count * entry.itemsize + 4)
    where = entries["where"].astype(np.int64)
    keys = _key(where[:, 1], where[:, 2], where[:, 3], where[:, 0])
    states = table.reshape(rows, STATES).astype(np.int64)
    order = simple + np.argsort(keys[simple:])
    return _Definitions(
        tuple(name.decode() for name in names),
        silence,
        frozenset(np.flatnonzero(where[:simple, 0]).tolist()),
        tuple(map(tuple, states[entries["row"][:simple]].tolist())),
        keys[order],
        entries["row"][order].astype(np.int64),
        states,
    )


def _gaussians(path: Path) -> Floats:
    """Read (books, streams, Gaussians, values)."""
    content, at = _body(path)
    books, streams, count = struct.unpack_from("<3i", content, at)
    lengths = struct.unpack_from(f"<{streams}i", content, at + 12)
    if streams != STREAMS or len(set(lengths)) != 1:
        raise ValueError(f"{path.name} has streams of another form")
    size = books * streams * count * lengths[0]
    values = np.frombuffer(content, "<f4", size, at + 16 + 4 * streams)
    return values.reshape(books, streams, count, lengths[0]).astype(np.float64)


def _table(path: Path) -> Floats:
    """Read a flat table; its length is the last of four numbers before it."""
    content, at = _body(path)
    (size,) = struct.unpack_from("<i", content, at + 12)
    return np.frombuffer(content, "<f4", size, at + 16).astype(np.float64)


def _body(path: Path) -> tuple[bytes, int]:
    """Return what a file holds, and where its numbers start."""
    content = path.read_bytes()
    at = content.index(b"endhdr\n") + 7
    if struct.unpack_from("<I", content, at) != (0x11223344,):
        raise ValueError(f"{path.name} is of another byte order")
    return content, at + 4


def _weights(path: Path, count: int, states: int) -> Singles:
    """Read quantised weights: (streams, Gaussians, states)."""
    content = path.read_bytes()
    at, said = _strings(content)
    if "cluster_count 0" not in said:
        raise ValueError(f"{path.name} is clustered")
    rows, columns = struct.unpack_from("<2i", content, at)
    if rows != count or columns < states:
        raise ValueError(f"{path.name} does not fit the other files")
    steps = np.frombuffer(content, "u1", STREAMS * rows * columns, at + 8)
    weights = np.exp(-STEP * np.arange(256)).astype(np.float32)
    found: Singles = weights[steps.reshape(STREAMS, rows, columns)]
    return found


def _strings(content: bytes) -> tuple[int, list[str]]:
    """Return where the strings end that a file starts with, and the strings."""
    at = 0
    strings: list[str] = []
    while True:
        (size,) = struct.unpack_from("<i", content, at)
        at += 4
        if size <= 0:
            return at, strings
        strings.append(content[at : at + size].rstrip(b"\0").decode())
        at += size
