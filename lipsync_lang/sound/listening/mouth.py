"""The mouth: curves of poses that follow a belief about phones, without looking ahead.

The mouth goes to the expected target: the mean of the targets of all phones, each as likely as it
is. So doubt gives a half-open mouth that never flickers. Half a contact is none: phones that demand
it, together likelier than `CLOSES`, close it fully.

Conventions: P poses, N phones of three states; frames are those of the ear. The stages are those
of a whole line, turned to the past: half a kernel softens the targets, contacts are held, and a
speed limit follows the result. The constraints come last, at the frames that are shown: they lower
a pose no faster than another rises, so the speed limit still holds.
"""

from collections.abc import Mapping, Sequence
from math import ceil

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.tables import RESOLUTION, Tables
from lipsync_lang.resolver.nearest_phonemes import ModelPhones
from lipsync_lang.schedules.schedule import SILENCE
from lipsync_lang.sound.speech.hearing.sphinx.features import FRAME_SECONDS
from lipsync_lang.text.phonology.labels import Notation, Value
from lipsync_lang.text.phonology.nearest import NearestPhonemes

CLOSES = 0.65
"""Probability of the phones of a contact that closes it."""

OPENS = 0.3
"""Probability of these phones below which it opens again."""

HELD_FRAMES = 3
"""Frames for which a contact is held at least, once the lips are there."""

SOFT_FRAMES = 10
"""Frames before a frame whose targets count in its own, less and less."""


def heard_labels(known: ModelPhones, notation: Notation) -> dict[str, str]:
    """Return for each phone of a model the label of a language that sounds most like it.

    Parameters
    ----------
    notation : of the language, in IPA
    """
    table = {label: (label,) for label in notation.table}
    by_ear = NearestPhonemes(known.nearest.features, table)
    found: dict[str, str] = {}
    for phone, letters in known.nearest.candidates.items():
        own = next((label for label in letters if notation.find(label) is not None), None)
        near = None if own else by_ear.value(letters[0])
        found[phone] = own or (near[0][0] if near else SILENCE)
    return found


def heard_values(known: ModelPhones, notation: Notation) -> dict[str, Value]:
    """Return the common phonemes of each phone of a model, as a language has them."""
    labels = heard_labels(known, notation).items()
    return {phone: notation.find(label) or () for phone, label in labels}


def state_targets(
    tables: Tables, values: Sequence[Value], numbers: Mapping[str, int]
) -> tuple[Floats, list[Bools]]:
    """Return the target of each state of each phone, and the states that demand each contact.

    Parameters
    ----------
    values : of each phone; one without any rests
    numbers : number of each common phoneme in the tables

    Returns
    -------
    (N, 3, P) weights, and (N, 3) for each contact
    """
    targets = np.zeros((len(values), 3, len(tables.priority)))
    demands = [np.zeros((len(values), 3), bool) for _ in tables.contacts]
    for phone, value in enumerate(values):
        sounds = [numbers[name] for name, _ in value]
        ends = np.cumsum([share for _, share in value])
        for state in range(3 if sounds else 0):
            # the sound that has the middle of the state, and where in it that lies
            middle = (state + 0.5) / 3 * ends[-1]
            at = int(np.searchsorted(ends, middle))
            begin = ends[at - 1] if at else 0.0
            within = (middle - begin) / (ends[at] - begin)
            first, last = _ends(tables, sounds[at])
            targets[phone, state] = first + np.interp(within, (0.25, 0.75), (0, 1)) * (last - first)
            for demanded, contact in zip(demands, tables.contacts, strict=True):
                demanded[phone, state] = contact.phonemes[sounds[at]]
    return targets, demands


def _ends(tables: Tables, phoneme: int) -> tuple[Floats, Floats]:
    """Return the weights at the first and the last step of a phoneme beside itself: (P,) each.

    The bigram of a phoneme with itself is at its target around its boundary; of one that moves,
    the last step lies before it and the first one after it (`banks.draft`).
    """
    row = tables.pairs[phoneme, phoneme]
    boundary = float(tables.boundary[row])
    places = (boundary + (1 - boundary) / 3, boundary * 2 / 3)
    first, last = (tables.curves[row, round(at * RESOLUTION)].astype(float) for at in places)
    return first, last


class Mouth:
    """Curves of poses, from a belief that arrives in parts.

    Parameters
    ----------
    targets, demands : as from `state_targets`
    """

    def __init__(
        self, tables: Tables, motion: Motion, targets: Floats, demands: Sequence[Bools]
    ) -> None:
        self.tables = tables
        poses = targets.shape[-1]
        self._targets = targets.reshape(-1, poses)
        self._demands = np.array([one.ravel() for one in demands]).reshape(len(demands), -1)
        self._step = motion.speed_limit * FRAME_SECONDS
        fading = 1 + np.cos(np.pi * np.arange(SOFT_FRAMES, -1, -1) / (SOFT_FRAMES + 1))
        self._fading = fading / fading.sum()
        self._wanted = np.zeros((SOFT_FRAMES, poses))
        self._now = np.zeros(poses)
        self._held = [0] * len(demands)

    def push(self, belief: Floats) -> Floats:
        """Return the curves at each frame of a belief (k, N, 3), before the constraints: (k, P)."""
        flat = belief.reshape(len(belief), len(self._targets))
        sure = flat @ self._demands.T
        wanted = np.concatenate([self._wanted, flat @ self._targets])
        self._wanted = wanted[len(flat) :]
        curves = np.empty((len(flat), wanted.shape[1]))
        for frame in range(len(flat)):
            goal = self._fading @ wanted[frame : frame + len(self._fading)]
            for number, contact in enumerate(self.tables.contacts):
                if self._touches(number, sure[frame, number]):
                    goal = np.maximum(np.minimum(goal, contact.ceiling), contact.floor)
            move = np.minimum(np.maximum(goal - self._now, -self._step), self._step)
            self._now = curves[frame] = self._now + move
        return curves

    def _touches(self, number: int, sure: float) -> bool:
        """Return True while a contact is held, whose phones are so likely."""
        held = self._held[number]
        if held:
            held = max(held - 1, int(sure >= OPENS))
        elif sure >= CLOSES:
            # the lips move no faster than the speed limit, up to the floor or down to the ceiling
            contact = self.tables.contacts[number]
            away = max((contact.floor - self._now).max(), (self._now - contact.ceiling).max(), 0.0)
            held = ceil(away / self._step) + HELD_FRAMES
        self._held[number] = held
        return held > 0
