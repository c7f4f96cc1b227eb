"""Recordings without a text: the phonemes that the belief about their sound supports.

Half of the phones that a sound alone decides for are wrong, but many of the wrong ones look right.
So at each frame the phone is wanted whose mouth is expected to differ least from the true one:

    risk(n) = sum over m of belief(m) (looks(m, n) + (n and m have different labels))

Their sequence is the path of the least risk, where each change of the phone costs something.

T frames, N phones.
"""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise, product

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints, Singles
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.finding import IPA
from lipsync_lang.resolver.nearest_phonemes import ModelPhones, model_phones
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.sound.listening.belief import smoothed
from lipsync_lang.sound.listening.ear import (
    FAST_FRAMES,
    ToneTrack,
    VoiceGate,
    change_of,
    contrast_of,
    phone_scores,
)
from lipsync_lang.sound.listening.mouth import heard_labels
from lipsync_lang.sound.speech.hearing import progress
from lipsync_lang.sound.speech.hearing.recognise.recognisers import recogniser
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.sound.speech.hearing.sphinx.decoders import parts
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    FRAME_SECONDS,
    WINDOW_SAMPLES,
    PreparedSound,
)
from lipsync_lang.sound.speech.hearing.sphinx.folder import Models, find_models
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import WINDOW_CENTRE_SECONDS, timed_labels
from lipsync_lang.sound.speech.sound import SPEECH_RATE, resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker

CHANGE_RISK = 0.3
"""Price of another phone; the mean distance of two phones is 1."""

ANOTHER_RISK = 0.5
"""Risk of another label, beside what is seen of it."""

LIKELIEST = 6
"""Number of labels that are kept of each phoneme."""

SOUND_REMARK = (
    "the mouth follows the sound alone: no words were recognised, some lip closures are missed or "
    "invented, and music moves it too"
)
NOTHING_REMARK = "nothing was heard: no part of the recording sounds like a voice"


@recogniser("sound")
class SoundRecogniser:
    """Recogniser of sounds without words, for a voice in any language."""

    def recognise(self, audio: Audio, speaker: Speaker, model: str | None = None) -> Schedule:
        """Recognise the phonemes of a recording, as `Recogniser` states.

        `model` names an acoustic model; None stands for the one that hears every language. A
        language without IPA is a `SpeechError`.
        """
        known, notation = model_phones(), speaker.notations.get(IPA)
        if known is None:
            raise SpeechError("the pack of the IPA names no acoustic model (`hearing`)")
        if notation is None:
            raise SpeechError(
                f"{speaker.manner.language} has no notation '{IPA}', which heard sounds need: give "
                "its pack one"
            )
        models = find_models(model or known.model)
        known = models.phones
        if known is None:
            raise SpeechError(
                f"{models.acoustic}: no phone of the model is known in IPA: write phones.yaml "
                "there, with a line `PHONE: LETTERS` for each phone"
            )
        spelled = heard_labels(known, notation)
        labels = [spelled.get(name, SILENCE) for name in models.model.names]
        # a frame whose middle is behind the end would begin a phoneme there
        inside = round((audio.seconds - WINDOW_CENTRE_SECONDS) / FRAME_SECONDS)
        belief = recorded_belief(audio, known, models)[: max(inside, 1)]
        # phones with one label are one sound
        path = np.array([labels.index(label) for label in labels])[
            likeliest_path(belief.astype(np.float64) @ risks(known, models.model.names))
        ]
        edges = [0, *(np.flatnonzero(np.diff(path)) + 1).tolist(), len(path)]
        heard = [HeardPhoneme(OUTSIDE, int(path[a]), a, z, 0.0) for a, z in pairwise(edges)]
        found = timed_labels(models, heard, (), audio.seconds)
        return Schedule(
            tuple(spelled.get(name, name) for name in found.labels), found.times, notation=IPA,
            language=speaker.manner.language, audio=audio, source="recording", recognised=True,
            remarks=(NOTHING_REMARK if {*found.labels} == {SILENCE} else SOUND_REMARK,),
            likely=likeliest(belief, labels, found.times),
        )  # fmt: skip


def recorded_belief(audio: Audio, known: ModelPhones, models: Models) -> Singles:
    """Return the probability of each phone in each frame of a recording: (T, N).

    The sound is heard in parts, so that an hour needs little memory.
    """
    scores = phone_scores(models.model, known.neighbours)
    sound = resampled(audio, SPEECH_RATE).samples
    gain = PreparedSound.of(Audio(sound, SPEECH_RATE)).gain
    found = []
    for start, stop in parts(sound):
        progress.tell(start, len(sound))
        here = Audio(sound[start:stop], SPEECH_RATE)
        part = PreparedSound(here, gain, 0, stop - start).samples()
        heard = models.model.front_end(part)
        scored, tones = scores.of(heard), ToneTrack().push(np.pad(part, (0, WINDOW_SAMPLES)))
        measures = change_of(heard), tones[: len(heard)], contrast_of(scored, scores.loop.quiet)
        # a voice is told by the frames around, not only by those before
        ahead = FAST_FRAMES // 2
        wide = (np.pad(measure, (0, ahead), mode="edge") for measure in measures)
        belief = scores.loop.calmed(smoothed(scores.loop, scored), VoiceGate().push(*wide)[ahead:])
        found.append(belief.sum(axis=-1).astype(np.float32))
    return np.concatenate(found)


@cache
def risks(known: ModelPhones, names: Sequence[str]) -> Singles:
    """Return the risk of showing a phone, in columns, where another one is said, in rows: (N, N).

    Phones are compared at their begin and at their end. Silence is as far from all as these are
    from each other in the mean.
    """
    looks = known.looks
    runs = [looks.read(looks.candidates[name][0]).sounds if looks.candidates.get(name) else ()
            for name in names]  # fmt: skip
    far = np.zeros((len(names), len(names)))
    for (n, one), (m, other) in product(enumerate(runs), repeat=2):
        if one and other:
            far[n, m] = sum(
                looks.distance([one[end].features], [other[end].features]) for end in (0, -1)
            )
    far /= far[far > 0].mean()
    quiet = np.array([not run for run in runs])
    far[quiet[:, None] != quiet] = 1
    far += ANOTHER_RISK * ~np.eye(len(names), dtype=bool)
    return far.astype(np.float32)


def likeliest_path(risk: Floats | Singles) -> Ints:
    """Return the phone of each frame, (T,), whose risks, (T, N), and changes cost least."""
    count = risk.shape[1]
    here, before = np.arange(count), np.zeros(risk.shape, np.uint8)
    cost = np.zeros(count)
    for frame, now in enumerate(risk):
        best = int(cost.argmin())
        moved = cost > cost[best] + CHANGE_RISK
        before[frame] = np.where(moved, best, here)
        cost = np.where(moved, cost[best] + CHANGE_RISK, cost) + now
        cost -= cost.min()
    path = np.empty(len(risk), np.intp)
    phone = int(cost.argmin())
    for frame in range(len(risk) - 1, -1, -1):
        path[frame] = phone
        phone = int(before[frame, phone])
    return path


def likeliest(
    belief: Singles, labels: Sequence[str], times: Floats
) -> tuple[tuple[tuple[str, float], ...], ...]:
    """Return the likeliest labels of each phoneme with their mean probability, best first.

    Parameters
    ----------
    belief : (T, N)
    labels : of each phone
    times : boundaries of the phonemes, in seconds
    """
    names = sorted(set(labels))
    member = np.array([[label == name for name in names] for label in labels], np.float32)
    middles = (times - WINDOW_CENTRE_SECONDS) / FRAME_SECONDS
    edges = np.rint(middles).astype(int).clip(0, len(belief) - 1)
    found = []
    for first, stop in pairwise(edges.tolist()):
        mean = belief[first : max(stop, first + 1)].mean(axis=0, dtype=float) @ member
        best = (-mean).argsort(kind="stable")[:LIKELIEST].tolist()
        found.append(tuple((names[n], round(float(mean[n]), 3)) for n in best))
    return tuple(found)
