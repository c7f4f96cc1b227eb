"""Acoustic models by name or folder, with their phones in IPA, dictionary and language model."""

import json
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints, Singles
from lipsync_lang.base.errors import SpeechError, did_you_mean
from lipsync_lang.base.extensions import Extensions
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.files.reach import is_contained
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import (
    OUTSIDE,
    STATES,
    AcousticModel,
    Phone,
    WordPosition,
    context_key,
    gaussian_factors,
)
from lipsync_lang.sound.speech.hearing.sphinx.features import CEPSTRA, SphinxFrontEnd, band_edges
from lipsync_lang.sound.speech.sound import SPEECH_RATE

if TYPE_CHECKING:
    from lipsync_lang.resolver.nearest_phonemes import ModelPhones

WEIGHT_STEP = 1024 * np.log(1.0001)
"""Natural logarithm per step of a quantised weight."""

WEIGHT_FLOOR = 1e-7
"""Least mixture weight."""

MAX_REASON_CHARS = 100
"""Maximum length of what is wrong with a file, in a message."""

MAX_BANDS = 1000
"""Maximum number of mel bands, far beyond the points of a spectrum."""

SILENCE_NAME = "SIL"
"""Name of silence in all models of Sphinx."""

POSITIONS = dict(zip("ibes-", (*WordPosition, WordPosition.INSIDE), strict=True))
"""Positions in the word, as text spells them."""

FRONT_END: Mapping[str, tuple[str, Callable[[str], Any]]] = {
    "nfilt": ("bands", int),
    "lowerf": ("lowest", float),
    "upperf": ("highest", float),
    "transform": ("transform", str),
    "lifter": ("lifter", int),
    "remove_noise": ("quieted", "yes".__eq__),
}  # fmt: skip
"""Parameters of `feat.params` that the features follow, with their settings."""

OTHER_PARAMETERS: Mapping[str, Sequence[str] | None] = json.loads(
    Path(__file__).with_name("feature_parameters.json").read_text("utf-8")
)
"""Other parameters with the values that the features have; None if no feature depends on one."""

MODEL_FOLDER = "models"
"""The folder of a project with its models, each a folder."""

WHISPER_FILE = "model.bin"
"""A file of Whisper's models, which may be in that folder, too, and of no acoustic model."""

MODEL_READERS: Extensions[Callable[[Path], AcousticModel]] = Extensions(
    "acoustic_models", "reader of acoustic models"
)
"""Readers of folders with acoustic models of other forms, by the file that tells the form."""

model_reader = MODEL_READERS.register
"""Decorator that registers a function as the reader of folders with a file."""

LICENCE_FILES = ("LICENSE*", "LICENCE*", "COPYING*", "README*")
"""Patterns of files with a model's terms, the most telling first."""


def read_sphinx(folder: Path) -> AcousticModel:
    """Read a model of CMU Sphinx; another form is an `OSError`, or any error of the files' bytes.

    `mdef` is binary or text, and the weights are in `sendump` or `mixture_weights`. The numbers of
    codebooks and of states tell how they are tied. Features are `1s_c_d_dd`, as three streams of 13
    or as one of 39.
    """
    front_end = _front_end(folder)
    means, variances = (read_gaussians(folder / name) for name in ("means", "variances"))
    if means.shape[1] * means.shape[3] != 3 * CEPSTRA or means.shape != variances.shape:
        raise ValueError("means and variances have streams of another form")
    path = folder / "mdef"
    content = path.read_bytes()
    entries = _binary_entries(content) if content[:4] == b"BMDF" else _text_entries(content)
    weights = _weights(folder, means.shape[1:3], int(entries.states.max()) + 1)
    sizes, values = _numbers(folder / "transition_matrices")
    if sizes[1:] != (STATES, STATES + 1):
        raise ValueError(f"{sizes[1]} states per phoneme instead of {STATES}")
    moves = values.astype(np.float64).reshape(-1, STATES, STATES + 1)
    # The diagonal has the moves from a state to itself; rows of some models do not sum to 1.
    staying = np.einsum("pss->ps", moves[:, :, :STATES]) / moves.sum(axis=-1)
    simple = len(entries.names)
    # The first entries have no context. The others are sorted for a search by halves.
    keys = context_key(*entries.contexts.T)
    order = simple + np.argsort(keys[simple:])
    alone = entries.states[entries.rows[:simple]].tolist()
    return AcousticModel(
        entries.names, entries.names.index(SILENCE_NAME), entries.fillers,
        tuple(Phone(n, tuple(row)) for n, row in enumerate(alone)),
        keys[order], entries.rows[order], entries.states,
        # certain moves would leave no way out
        np.log(np.clip(staying[entries.moves[:simple]], 1e-6, 1 - 1e-6)),
        gaussian_factors(means, variances), weights,
        _books(entries, len(means), weights.shape[-1]), front_end,
    )  # fmt: skip


class ModelEntries(NamedTuple):
    """Phonemes of a model, first those without context: for each its context and states."""

    names: tuple[str, ...]
    fillers: frozenset[int]
    contexts: Ints
    """(entries, 4): numbers of the phoneme and its neighbours, and its position."""
    rows: Ints
    """Row of each entry in `states`."""
    moves: Ints
    """Number of each entry's transition matrix."""
    states: Ints


def _front_end(folder: Path) -> SphinxFrontEnd:
    """Return the settings of features; a parameter that cannot be followed is a `SpeechError`."""
    if (folder / "feature_transform").exists():
        raise refused(folder / "feature_transform", "-lda", "the features have no transform")
    path = folder / "feat.params"
    settings: dict[str, Any] = {}
    words = path.read_text("utf-8").split() if path.is_file() else []
    for name, value in zip(words[::2], words[1::2], strict=False):
        known = name.removeprefix("-")
        if known in FRONT_END:
            field, kind = FRONT_END[known]
            settings[field] = kind(value)
        elif known not in OTHER_PARAMETERS:
            raise refused(path, name, "this parameter is unknown")
        elif (fixed := OTHER_PARAMETERS[known]) is not None and not same_value(value, fixed):
            only = " or ".join(fixed) or "no such parameter"
            raise refused(path, f"{name} {value}", f"the features have {only}")
    made = SphinxFrontEnd(**settings)
    if not 0 < made.bands <= MAX_BANDS:
        raise refused(path, f"-nfilt {made.bands}", f"the features have 1 to {MAX_BANDS} bands")
    edges = band_edges(made)
    if made.transform not in ("legacy", "dct", "htk"):
        raise refused(path, f"-transform {made.transform}", "the features have legacy, dct or htk")
    # `not`, because bands that are no numbers compare with nothing.
    if not (edges[0] >= 0 and edges[-1] <= SPEECH_RATE / 2 and (np.diff(edges) > 0).all()):
        raise refused(path, "-nfilt, -lowerf, -upperf", "the bands overlap or leave 0 to 8000 Hz")
    return made


def refused(path: Path, what: str, why: str) -> SpeechError:
    """Return the error for a model whose features cannot be computed."""
    return SpeechError(
        f"{path}: {what}: {why}; take another model, or one that was trained with other features"
    )


def same_value(value: str, known: Sequence[str]) -> bool:
    """Return True for one of some values, numbers in any spelling."""
    try:
        return float(value) in map(float, known)
    except ValueError:
        return value in known


def read_gaussians(path: Path) -> Floats:
    """Read means or variances: (books, streams, Gaussians, values)."""
    content, at = _body(path)
    books, streams, count = struct.unpack_from("<3i", content, at)
    lengths = struct.unpack_from(f"<{streams}i", content, at + 12)
    if len(set(lengths)) != 1:
        raise ValueError(f"{path.name} has streams of different lengths")
    size = books * streams * count * lengths[0]
    values = np.frombuffer(content, "<f4", size, at + 16 + 4 * streams)
    return values.reshape(books, streams, count, lengths[0]).astype(np.float64)


def _body(path: Path) -> tuple[bytes, int]:
    """Return a file's content and the offset of its numbers."""
    content = path.read_bytes()
    # The mark of the byte order follows the head, which is text of any length.
    at = content.index(b"endhdr\n") + 7
    if struct.unpack_from("<I", content, at) != (0x11223344,):
        raise ValueError(f"{path.name} has another byte order")
    return content, at + 4


def _numbers(path: Path) -> tuple[tuple[int, ...], Singles]:
    """Return the three sizes of a table, and its values."""
    content, at = _body(path)
    *sizes, count = struct.unpack_from("<4i", content, at)
    return tuple(sizes), np.frombuffer(content, "<f4", count, at + 16)


def _binary_entries(content: bytes) -> ModelEntries:
    (skipped,) = struct.unpack_from("<i", content, 8)
    at = 12 + skipped
    simple, count, length, _, _, _, rows, _, nodes, _ = struct.unpack_from("<10i", content, at)
    if length != STATES:
        raise ValueError(f"{length} states per phoneme instead of {STATES}")
    at += 40
    names = content[at:].split(b"\0", simple)[:simple]
    # Names are padded to four bytes; the tree of contexts after them is not needed.
    at += -(-sum(len(name) + 1 for name in names) // 4) * 4 + nodes * 8
    entry = np.dtype([("row", "<i4"), ("moves", "<i4"), ("where", "u1", 4)])
    found = np.frombuffer(content, entry, count, at)
    table = np.frombuffer(content, "<u2", rows * STATES, at + count * entry.itemsize + 4)
    where = found["where"].astype(np.int64)
    fillers = frozenset(np.flatnonzero(where[:simple, 0]).tolist())
    contexts = where[:, [1, 2, 3, 0]]
    contexts[:simple, 0] = range(simple)
    return ModelEntries(
        tuple(name.decode() for name in names), fillers, contexts, found["row"].astype(np.int64),
        found["moves"].astype(np.int64), table.reshape(rows, STATES).astype(np.int64),
    )  # fmt: skip


def _text_entries(content: bytes) -> ModelEntries:
    lines = [
        line.split() for line in content.decode().splitlines() if line.strip() and line[0] != "#"
    ]
    rows = [row for row in lines if row[-1] == "N"]
    if any(len(row) != 7 + STATES for row in rows):
        raise ValueError(f"mdef has phonemes with another number of states than {STATES}")
    names = tuple(row[0] for row in rows if row[1] == "-" == row[2])
    numbers = {name: number for number, name in enumerate(names)} | {"-": OUTSIDE}
    contexts = [(*(numbers[name] for name in row[:3]), POSITIONS[row[3]]) for row in rows]
    fillers = (n for n, row in enumerate(rows[: len(names)]) if row[4] == "filler")
    return ModelEntries(
        names, frozenset(fillers), np.array(contexts), np.arange(len(rows)),
        np.array([int(row[5]) for row in rows]),
        np.array([[int(state) for state in row[6:-1]] for row in rows]),
    )  # fmt: skip


def _books(entries: ModelEntries, books: int, states: int) -> Ints:
    """Return the codebook of each state."""
    if books == 1:
        return np.zeros(states, np.int64)
    if books == len(entries.names):  # phonetically tied: that of the phoneme
        found = np.zeros(states, np.int64)
        found[entries.states[entries.rows]] = entries.contexts[:, :1]
        return found
    if books == states:
        return np.arange(states)
    raise ValueError(f"{books} codebooks for {len(entries.names)} phonemes and {states} states")


def _weights(folder: Path, sizes: tuple[int, int], states: int) -> Singles:
    """Read mixture weights: (streams, Gaussians, states)."""
    path = folder / "sendump"
    found: Singles
    if path.is_file():
        found = _quantised(path, sizes[0])
    else:
        path = folder / "mixture_weights"
        shape, values = _numbers(path)
        counts = np.moveaxis(values.reshape(shape), 0, -1)
        shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1e-30)
        found = np.maximum(shares, WEIGHT_FLOOR).astype(np.float32)
    if found.shape[:2] != sizes or found.shape[2] < states:
        raise ValueError(f"{path.name} does not fit the other files")
    return np.ascontiguousarray(found)


def _quantised(path: Path, streams: int) -> Singles:
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
    # A byte is the logarithm of a weight, in negative steps.
    steps = np.frombuffer(content, "u1", streams * rows * columns, at + 8)
    weights = np.exp(-WEIGHT_STEP * np.arange(256)).astype(np.float32)
    return weights[steps.reshape(streams, rows, columns)]


@dataclass(frozen=True)
class Models:
    """An acoustic model with its dictionary and language models.

    Parameters
    ----------
    folder : model folder; the files of the acoustic model are in it, or in a subfolder of its name
    given : an acoustic model in place of that in the folder
    """

    folder: Path
    given: AcousticModel | None = None

    @property
    def acoustic(self) -> Path:
        """The folder of the acoustic model."""
        inner = self.folder / self.folder.name
        return inner if inner.is_dir() else self.folder

    @property
    def dictionary(self) -> Path | None:
        """The pronunciation dictionary file; None without one, or with several."""
        found = [*self.folder.glob("*.dict"), *self.folder.glob("*.dic")]
        return found[0] if len(found) == 1 else None

    @property
    def language_model(self) -> Path | None:
        """The model of the order of words; None without one."""
        path = self.folder / f"{self.folder.name}.lm.bin"
        return path if path.is_file() else None

    @property
    def licence(self) -> Path | None:
        """The file with the terms of the model."""
        places = dict.fromkeys((self.acoustic, self.folder))
        found = (one for name in LICENCE_FILES for place in places for one in place.glob(name))
        return next(found, None)

    @cached_property
    def model(self) -> AcousticModel:
        """The acoustic model; phones that `phones.yaml` calls no speech are fillers in it."""
        if self.given is not None:
            return self.given
        model, known = read_model(self.acoustic), self.phones
        letters = known.nearest.candidates if known else {}
        mute = [n for n, name in enumerate(model.names) if not letters.get(name, True)]
        return replace(model, fillers=model.fillers | {*mute}) if mute else model

    @cached_property
    def phones(self) -> "ModelPhones | None":
        """The model's phones in IPA: those of its folder, or of the pack of the IPA; or None."""
        from lipsync_lang.resolver.nearest_phonemes import model_phones, phones_beside

        model = read_model(self.acoustic)
        speech = [name for n, name in enumerate(model.names) if n not in model.fillers]
        beside = phones_beside(self.acoustic, speech)
        known = None if beside else model_phones()
        named = known is not None and {*speech} <= {*known.nearest.candidates}
        return beside or (known if named else None)

    @cached_property
    def numbers(self) -> dict[str, int]:
        """The numbers of speech phonemes by name."""
        fillers = self.model.fillers
        return {name: n for n, name in enumerate(self.model.names) if n not in fillers}

    @cached_property
    def quiet(self) -> frozenset[int]:
        """The numbers of non-speech phonemes."""
        return self.model.fillers | {OUTSIDE}

    def ways(self, words: Iterable[str]) -> list[tuple[tuple[int, ...], ...]]:
        """Return the pronunciations of each word as phoneme numbers; none of an unknown word.

        An unreadable dictionary is a `SpeechError`.
        """
        ways: list[tuple[tuple[int, ...], ...]] = []
        for word in words:
            found: list[tuple[int, ...]] = []
            spelling = word
            while (phones := self._entries.get(spelling)) is not None:
                names = phones.split()
                if not names:
                    raise SpeechError(
                        f"{self.dictionary}: '{spelling}' has no phones; add them, or take its "
                        "line away"
                    )
                if unknown := [name for name in names if name not in self.numbers]:
                    raise SpeechError(
                        f"{self.dictionary}: '{spelling}' has '{unknown[0]}', which is no phone of "
                        "the model; take the dictionary away, or mend it"
                    )
                found.append(tuple(self.numbers[name] for name in names))
                spelling = f"{word}({len(found) + 1})"
            ways.append(tuple(found))
        return ways

    @cached_property
    def _entries(self) -> dict[str, str]:
        """Pronunciation by dictionary word; `WORD(2)` is a variant."""
        if self.dictionary is None:
            return {}
        try:
            lines = self.dictionary.read_text("utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise SpeechError(f"{self.dictionary}: cannot be read: {error}") from None
        return {word: phones for word, _, phones in (line.partition(" ") for line in lines)}


@cache
def read_model(folder: Path) -> AcousticModel:
    """Read the acoustic model in a folder, of CMU Sphinx or of a form that a plug-in reads.

    A file that is missing, truncated or of another kind is a `SpeechError`.
    """
    try:
        other = next((name for name in MODEL_READERS if (folder / name).is_file()), None)
        # What is beyond the range of a number ends as infinite, and is refused below.
        with np.errstate(all="ignore"):
            model = MODEL_READERS[other](folder) if other else read_sphinx(folder)
    except OSError as error:
        raise SpeechError(f"{folder}: no acoustic model: {error.strerror or error}") from None
    except (struct.error, ValueError, LookupError, ArithmeticError, MemoryError) as error:
        raise SpeechError(
            f"{folder}: not an acoustic model that can be read ({str(error)[:MAX_REASON_CHARS]}); "
            "install it again, or name another"
        ) from None
    if not all(np.isfinite(one).all() for one in (model.stay, model.gaussians, model.weights)):
        raise SpeechError(
            f"{folder}: some values of this acoustic model are no numbers; install it again, or "
            "name another"
        )
    return model


@cache
def models_in(folder: Path) -> Models:
    """Return the models in a folder, which are read once."""
    return Models(folder)


def own_folder(name: str) -> Path | None:
    """Return the folder of a model that the user brought, named by its path or in the project."""
    if any(sign in name for sign in "/\\~"):
        return Path(name).expanduser().absolute()
    path = _model_folder() / name
    if not name or name in {".", ".."} or not path.is_dir():
        return None
    if not is_contained(path, path.parent.parent):
        raise SpeechError(
            f"{path}: leads outside the project by a link; copy the model, or name its folder "
            "once: --path FOLDER"
        )
    return path


def find_models(name: str | None) -> Models:
    """Find the models in a folder, or with a name in the project or in pocketsphinx.

    It is a `SpeechError` if there is no such folder, or pocketsphinx is not installed, or has no
    model of that name.
    """
    folder = own_folder(name or "")
    if folder is not None:
        if not folder.is_dir():
            raise SpeechError(f"{name}: no such folder; name the folder of an acoustic model")
        return models_in(folder)
    spec = find_spec("pocketsphinx")
    if spec is None or spec.origin is None:
        raise SpeechError(
            "recognising words needs pocketsphinx, which is not installed; "
            f"get it with: {install_line('audio')}"
        )
    known = {one.folder.name: one for one in installed_models()}
    if name is None:
        raise SpeechError(
            "pocketsphinx needs a model, and the language names none: state it in its pack as "
            f"`audio: {{model: ...}}`; {did_you_mean('', known)}"
        )
    if name not in known:
        raise SpeechError(
            f"pocketsphinx has no model '{name}'; {did_you_mean(name, known)}; a folder is named "
            f"by its path: ./{name}"
        )
    return known[name]


def installed_models() -> Iterator[Models]:
    """Yield the models with a name: those of the project, and then those of pocketsphinx."""
    spec = find_spec("pocketsphinx")
    yield from (models_in(path) for path in project_models() if not is_whisper(path))
    if spec and spec.origin:
        yield from map(models_in, _folders(Path(spec.origin).parent / "model"))


def project_models() -> list[Path]:
    """Return the folders of all models of the project, or in the current folder without one."""
    place = _model_folder()
    return [path for path in _folders(place) if is_contained(path, place.parent)]


def is_whisper(folder: Path) -> bool:
    """Return True for a folder with a model of Whisper."""
    return (folder / WHISPER_FILE).is_file()


def _model_folder() -> Path:
    from lipsync_lang.packs.project import find_project

    project = find_project()
    return (project.parent if project else Path().absolute()) / MODEL_FOLDER


def _folders(place: Path) -> list[Path]:
    return [path for path in sorted(place.glob("*")) if path.is_dir()]
