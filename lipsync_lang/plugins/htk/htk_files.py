"""Readers of HTK monophones: text files `hmmdefs`, and the definitions in `macros`.

States are mixtures of diagonal Gaussians in one stream; `sp`, which is a pause of any length, is
not needed. A phoneme passes through its states in order: moves past a state or back are left out.
"""

import re
from collections.abc import Iterator
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang import SpeechError
from lipsync_lang.base.arrays import Floats, Singles
from lipsync_lang.plugins.htk.htk_front_end import CONFIG, HtkFrontEnd, kept_features
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import (
    STATES,
    AcousticModel,
    Phone,
    gaussian_factors,
)
from lipsync_lang.sound.speech.hearing.sphinx.folder import model_reader

HMMDEFS = "hmmdefs"
"""The file of models."""

SHORT_PAUSE = "sp"
"""Name of the pause that may have no length."""

SILENCE_NAMES = ("sil", "SIL", "#", "silB", "pau")
"""Names of silence; the first that a model has counts."""

UNREACHED = -1e30
"""Constant of a Gaussian that fills up a state with few."""

_TOKEN = re.compile(r'"[^"]*"|<[^<>]*>|~[a-z]|[^\s<]+')


class MixturePart(NamedTuple):
    """A Gaussian of a state with its weight."""

    weight: float
    mean: Floats
    variance: Floats


class HtkPhone(NamedTuple):
    """States of a phone, each with its Gaussians, and its (states + 2) square transitions."""

    states: list[list[MixturePart]]
    moves: Floats


class _Definitions:
    """Reader of definitions; `~` begins the name of a shared one."""

    def __init__(self, path: Path) -> None:
        self.path, self.line = path, 1
        self.kind, self.size = "", 0
        self.phones: dict[str, HtkPhone] = {}
        self.named: dict[tuple[str, str], Any] = {}
        self.tokens: list[tuple[str, int]] = []
        self.at = 0

    def read(self, path: Path) -> None:
        """Read the definitions of a file after those of others."""
        text = path.read_text("utf-8", "replace")
        if "\0" in text or "~" not in text[:200]:
            raise SpeechError(f"{path}: is no text; convert it with HHEd, or take the text form")
        self.path, self.at = path, 0
        self.tokens = [
            (word, number)
            for number, line in enumerate(text.splitlines(), 1)
            for word in _TOKEN.findall(line)
        ]
        while self.at < len(self.tokens):
            self._definition(self._next())

    def _definition(self, sign: str) -> None:
        if sign == "~o":
            self._options()
            return
        name = self._next().strip('"')
        if sign == "~h":
            self.phones[name] = self._phone()
        elif sign == "~s":
            self.named[sign, name] = self._state()
        elif sign == "~m":
            self.named[sign, name] = self._gaussian(1.0)
        elif sign in ("~u", "~v", "~t"):
            self.named[sign, name] = self._table(self._next())
        else:
            raise self._wrong(sign)

    def _next(self) -> str:
        if self.at == len(self.tokens):
            raise SpeechError(f"{self.path}: ends within a definition; get the whole file")
        word, self.line = self.tokens[self.at]
        self.at += 1
        # Keywords may be in any case; names between quotes may not.
        return word.upper() if word[0] == "<" else word

    def _peek(self) -> str:
        return self.tokens[self.at][0].upper() if self.at < len(self.tokens) else ""

    def _wrong(self, word: str) -> SpeechError:
        return SpeechError(
            f"{self.path}:{self.line}: '{word}' is not read here: monophones with {STATES} states "
            "of diagonal Gaussians in one stream are; take such a model"
        )

    def _options(self) -> None:
        """Read the size and the kind of features."""
        while self._peek().startswith("<") and self._peek() != "<NUMSTATES>":
            word = self._next()
            if word == "<VECSIZE>":
                self.size = int(self._next())
            elif word == "<STREAMINFO>":
                if self._next() != "1":
                    raise self._wrong(word)
                self._next()
            elif word not in ("<DIAGC>", "<NULLD>"):
                if not word[1:].startswith(("MFCC", "PLP", "LPC", "FBANK", "USER", "MELSPEC")):
                    raise self._wrong(word)
                self.kind = word.strip("<>")

    def _phone(self) -> HtkPhone:
        if self._next() != "<BEGINHMM>":
            raise self._wrong("~h")
        self._options()
        states: list[list[MixturePart]] = []
        moves = np.zeros((0, 0))
        while (word := self._next()) != "<ENDHMM>":
            if word == "<STATE>":
                self._next()
                states.append(self._state())
            elif word in ("<TRANSP>", "~t"):
                self.at -= 1
                moves = self._vector("~t", word)
            elif word == "<NUMSTATES>":
                self._next()
            else:
                raise self._wrong(word)
        return HtkPhone(states, moves)

    def _referred(self, sign: str) -> Any:
        """Return what a name refers to; None if no name comes next."""
        if self._peek() != sign.upper():
            return None
        self._next()
        name = self._next().strip('"')
        if (sign, name) not in self.named:
            raise SpeechError(f"{self.path}:{self.line}: nothing is named {sign} '{name}'")
        return self.named[sign, name]

    def _state(self) -> list[MixturePart]:
        found: list[MixturePart] | None = self._referred("~s")
        if found is not None:
            return found
        if self._peek() == "<NUMMIXES>":
            self.at += 2
        if self._peek() != "<MIXTURE>":
            return [self._gaussian(1.0)]
        parts = []
        while self._peek() == "<MIXTURE>":
            self.at += 2
            weight = float(self._next())
            parts.append(self._gaussian(weight))
        return parts

    def _gaussian(self, weight: float) -> MixturePart:
        found: MixturePart | None = self._referred("~m")
        if found is not None:
            return found._replace(weight=weight)
        mean = self._vector("~u", "<MEAN>")
        variance = self._vector("~v", "<VARIANCE>")
        # The constant follows from the variances, and some tools leave it out.
        if self._peek() == "<GCONST>":
            self.at += 2
        return MixturePart(weight, mean, variance)

    def _vector(self, sign: str, keyword: str) -> Floats:
        """Read a vector, or return the shared one of a name."""
        found: Floats | None = self._referred(sign)
        if found is not None:
            return found
        word = self._next()
        if word != keyword:
            raise self._wrong(word)
        return self._table(word)

    def _table(self, keyword: str) -> Floats:
        size = int(self._next())
        shape = (size, size) if keyword == "<TRANSP>" else (size,)
        return np.array([float(self._next()) for _ in range(prod(shape))]).reshape(shape)


@model_reader(HMMDEFS)
def read_htk(folder: Path) -> AcousticModel:
    """Read monophones; features or models of another kind are a `SpeechError`."""
    found = _Definitions(folder / HMMDEFS)
    # In this order: models refer to states and vectors that `macros` defines.
    for path in (folder / "macros", folder / HMMDEFS):
        if path.is_file() or path.name == HMMDEFS:
            found.read(path)
    path = folder / HMMDEFS
    kept, features = kept_features(found.kind, found.size, path)
    phones = {name: one for name, one in found.phones.items() if name != SHORT_PAUSE}
    for name, one in phones.items():
        if len(one.states) != STATES:
            raise SpeechError(
                f"{path}: '{name}' has {len(one.states)} states instead of {STATES}; take a model "
                f"of {STATES}"
            )
    names = tuple(phones)
    silence = next((one for one in SILENCE_NAMES if one in names), None)
    if silence is None:
        raise SpeechError(f"{path}: no phone is silence ({', '.join(SILENCE_NAMES)})")
    states = [state for one in phones.values() for state in one.states]
    gaussians, weights = _mixtures(states, list(kept))
    stay = np.array([list(_staying(one.moves)) for one in phones.values()])
    number = names.index(silence)
    return AcousticModel(
        names, number, frozenset([number]),
        tuple(Phone(n, tuple(range(n * STATES, (n + 1) * STATES))) for n in range(len(names))),
        np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, STATES), np.int64),
        np.log(stay), gaussians, weights,
        np.arange(len(states)), HtkFrontEnd.of(features, folder / CONFIG),
    )  # fmt: skip


def _mixtures(states: list[list[MixturePart]], kept: list[int]) -> tuple[Singles, Singles]:
    """Return Gaussians and weights as `AcousticModel` has them, filled up to equal numbers."""
    most = max(map(len, states))
    gaussians = np.zeros((len(states), 1, 2 * len(kept) + 1, most), np.float32)
    gaussians[:, :, -1] = UNREACHED
    weights = np.zeros((1, most, len(states)), np.float32)
    for number, parts in enumerate(states):
        means = np.array([one.mean[kept] for one in parts])
        variances = np.array([one.variance[kept] for one in parts])
        gaussians[number, 0, :, : len(parts)] = gaussian_factors(means, variances)
        weights[0, : len(parts), number] = [one.weight for one in parts]
    return gaussians, weights


def _staying(moves: Floats) -> Iterator[float]:
    """Yield the probability of each state to stay, against the move to the next."""
    for state in range(1, STATES + 1):
        stay, go = moves[state, state], moves[state, state + 1]
        yield float(np.clip(stay / max(stay + go, 1e-30), 1e-6, 1 - 1e-6))
