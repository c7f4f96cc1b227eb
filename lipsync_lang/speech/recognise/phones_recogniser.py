"""Recognition without words: the phonemes that an acoustic model hears, in any language.

The model may be of another language; its phones become IPA that the language's pack knows.
"""

from typing import TYPE_CHECKING

from lipsync_lang.errors import SpeechError
from lipsync_lang.packs.finding import IPA
from lipsync_lang.phonology.nearest import NearestPhonemes
from lipsync_lang.resolver.nearest_phonemes import ModelPhones, model_phones
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.speech import listening
from lipsync_lang.speech.recognise.recognisers import recogniser
from lipsync_lang.speech.sphinx.decoders import decoded_phones, parts
from lipsync_lang.speech.sphinx.features import STEP
from lipsync_lang.speech.sphinx.folder import find_models
from lipsync_lang.speech.sphinx.scheduling import laid, prepared

if TYPE_CHECKING:
    from lipsync_lang.speech.speaking import Speaker
    from lipsync_lang.speech.sphinx.forced import HeardPhoneme

SOUNDS = "the mouth follows single sounds: words were not recognised, and music also moves it"
NOTHING = "nothing was heard"


@recogniser("phones")
class PhonesRecogniser:
    """Recogniser of single sounds, for recordings in a language that nothing else hears."""

    def recognise(self, audio: Audio, speaker: "Speaker", model: str | None = None) -> Schedule:
        """Recognise the phonemes of a recording.

        Parameters
        ----------
        audio : the recording
        speaker : its language
        model : name of a pocketsphinx model; None for the one that hears every language

        Raises
        ------
        SpeechError
            The model is unknown, or the language has no IPA.
        """
        known = model_phones()
        if known is None:
            raise SpeechError("the pack of the IPA names no acoustic model (`hearing`)")
        models = find_models(model or known.model)
        labels = spellings(known, speaker)
        sound = prepared(audio)
        heard: list[HeardPhoneme] = []
        for start, stop in parts(sound):
            listening.tell(start, len(sound))
            first = start // STEP
            heard += [
                one._replace(first=one.first + first, stop=one.stop + first)
                for one in decoded_phones(models, sound[start:stop])
            ]
        found = laid(models, heard, (), audio.seconds)
        return Schedule(
            tuple(labels.get(name, name) for name in found.labels),
            found.times,
            notation=IPA,
            language=speaker.manner.language,
            audio=audio,
            source="recording",
            remarks=(NOTHING if {*found.labels} == {SILENCE} else SOUNDS,),
            recognised=True,
        )


def spellings(known: ModelPhones, speaker: "Speaker") -> dict[str, str]:
    """Return for each phone of a model the label of IPA, in a language, that sounds most like it.

    Raises
    ------
    SpeechError
        The language has no IPA.
    """
    notation = speaker.notations.get(IPA)
    if notation is None:
        raise SpeechError(
            f"{speaker.manner.language} has no notation '{IPA}', which recognised phonemes need: "
            "give "
            "its pack one"
        )
    found: dict[str, str] = {}
    for phone, letters in known.nearest.candidates.items():
        own = next((label for label in letters if notation.find(label) is not None), None)
        found[phone] = own or _nearest(known, [*notation.table], letters[0])
    return found


def _nearest(known: ModelPhones, labels: list[str], letters: str) -> str:
    """Return the label that sounds most like some letters; silence if no letter is IPA."""
    by_ear = NearestPhonemes(known.nearest.features, {label: (label,) for label in labels})
    value = by_ear.value(letters)
    return value[0][0] if value else SILENCE
