"""Recognition without words: the phonemes that an acoustic model hears, in any language.

The model may be of another language; its phones become IPA that the language's pack knows.
"""

from typing import TYPE_CHECKING

from lipsync_lang.errors import SpeechError
from lipsync_lang.packs.finding import IPA
from lipsync_lang.phonology.nearest import NearestPhonemes
from lipsync_lang.resolver.nearest_phonemes import ModelPhones, model_phones
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.speech.hearing import progress
from lipsync_lang.speech.hearing.recognise.recognisers import recogniser
from lipsync_lang.speech.hearing.sphinx.decoders import decoded_phones, parts
from lipsync_lang.speech.hearing.sphinx.features import HOP_SAMPLES
from lipsync_lang.speech.hearing.sphinx.folder import find_models
from lipsync_lang.speech.hearing.sphinx.scheduling import prepared, timed_labels

if TYPE_CHECKING:
    from lipsync_lang.speech.hearing.sphinx.forced import HeardPhoneme
    from lipsync_lang.speech.speaking.speaker import Speaker

SOUNDS_REMARK = (
    "the mouth follows single sounds: words were not recognised, and music also moves it"
)
NOTHING_REMARK = "nothing was heard"


@recogniser("phones")
class PhonesRecogniser:
    """Recogniser of single sounds, for recordings in a language that nothing else hears."""

    def recognise(self, audio: Audio, speaker: "Speaker", model: str | None = None) -> Schedule:
        """Recognise the phonemes of a recording, as `Recogniser` states.

        `model` names a pocketsphinx model; None stands for the one that hears every language. A
        language without IPA is a `SpeechError`.
        """
        known = model_phones()
        if known is None:
            raise SpeechError("the pack of the IPA names no acoustic model (`hearing`)")
        models = find_models(model or known.model)
        labels = spellings(known, speaker)
        sound = prepared(audio)
        heard: list[HeardPhoneme] = []
        for start, stop in parts(sound):
            progress.tell(start, len(sound))
            first = start // HOP_SAMPLES
            heard += [
                one._replace(first=one.first + first, stop=one.stop + first)
                for one in decoded_phones(models, sound[start:stop])
            ]
        found = timed_labels(models, heard, (), audio.seconds)
        return Schedule(
            tuple(labels.get(name, name) for name in found.labels),
            found.times,
            notation=IPA,
            language=speaker.manner.language,
            audio=audio,
            source="recording",
            remarks=(NOTHING_REMARK if {*found.labels} == {SILENCE} else SOUNDS_REMARK,),
            recognised=True,
        )


def spellings(known: ModelPhones, speaker: "Speaker") -> dict[str, str]:
    """Return for each phone of a model the label of IPA, in a language, that sounds most like it.

    A language without IPA is a `SpeechError`.
    """
    notation = speaker.notations.get(IPA)
    if notation is None:
        raise SpeechError(
            f"{speaker.manner.language} has no notation '{IPA}', which recognised phonemes need: "
            "give "
            "its pack one"
        )
    table = {label: (label,) for label in notation.table}
    by_ear = NearestPhonemes(known.nearest.features, table)
    found: dict[str, str] = {}
    for phone, letters in known.nearest.candidates.items():
        own = next((label for label in letters if notation.find(label) is not None), None)
        near = None if own else by_ear.value(letters[0])
        found[phone] = own or (near[0][0] if near else SILENCE)
    return found
