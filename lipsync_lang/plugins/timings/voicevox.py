"""VOICEVOX and engines like it: the JSON of an `audio_query`, or its list of `accent_phrases`.

Accent phrases have moras, each a vowel and maybe a consonant, with lengths in seconds. The voice is
the sum of those lengths, as the engine computes it: silence before and after, pauses scaled, all
divided by the speed, and each sound rounded to a whole frame. A question lengthens its last vowel.
"""

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import SILENCE, LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.timing_file import first_item, plain_fields

VOICEVOX_FPS = 24_000 / 256

QUESTION_SECONDS = 0.15
"""Length of the vowel that the engine adds to a question, before its speed counts."""

VOICEVOX_FORM = (
    '{"accent_phrases": [{"moras": [{"text": "マ", "consonant": "m", "consonant_length": 0.08, '
    '"vowel": "a", "vowel_length": 0.12}]}], "speedScale": 1.0, "prePhonemeLength": 0.1}'
)

TimedSound = tuple[str, float]
"""A label and its length in seconds before the speed counts."""


def sniff(source: TimingFile) -> bool:
    """Return True if the JSON has accent phrases."""
    first = first_item(source.document)
    listed = isinstance(first, dict) and "moras" in first
    return listed or source.holds("accent_phrases") or source.holds("accentPhrases")


@reader("voicevox", ".json", sniff=sniff)
def read_voicevox(source: TimingFile) -> Schedule:
    """The audio_query of VOICEVOX: consonants and vowels with their lengths, and kana."""
    phrases = {"accent_phrases": source.json} if isinstance(source.json, list) else source.json
    query = plain_fields(phrases)
    speed = _number(source, query, "speedscale", 1.0)
    if speed <= 0:
        raise source.fault("speedScale must be above 0")
    rows: list[LabelRow] = []
    words: list[LabelRow] = []
    at = _frames(_number(source, query, "prephonemelength", 0.0) / speed)
    sounds = 0
    for phrase in _objects(source, query, "accentphrases"):
        moras = _objects(source, phrase, "moras")
        spoken: list[TimedSound] = []
        for mora in moras:
            for kind in ("consonant", "vowel") if mora.get("consonant") else ("vowel",):
                length = _number(source, mora, f"{kind}length", 0.0)
                spoken.append((str(mora.get(kind, "")), length))
        asks = moras and phrase.get("isinterrogative")
        if asks and _number(source, moras[-1], "pitch", 0.0) > 0:
            spoken.append((str(moras[-1].get("vowel", "")), QUESTION_SECONDS))
        start = at
        for sound in spoken:
            at = _add(rows, sound, at, speed)
        sounds += len(spoken)
        text = "".join(str(mora.get("text", "")) for mora in moras)
        words.append(LabelRow(text, start / VOICEVOX_FPS, at / VOICEVOX_FPS))
        if isinstance(phrase.get("pausemora"), dict):
            stated = _number(source, plain_fields(phrase["pausemora"]), "vowellength", 0.0)
            pause = _number(source, query, "pauselength", stated)
            pause *= _number(source, query, "pauselengthscale", 1.0)
            at = _add(rows, (SILENCE, pause), at, speed)
    _add(rows, (SILENCE, _number(source, query, "postphonemelength", 0.0)), at, speed)
    if all(row.label == SILENCE for row in rows):
        raise source.fault("has no lengths of sounds; ask the engine for an audio_query")
    short = sounds - sum(row.label != SILENCE for row in rows)
    told = f"{source.path}: sounds shorter than half a frame are ignored: {short}"
    return schedule_of(source, rows, words=words, rate=1.0, remarks=[told] if short else ())


def _add(rows: list[LabelRow], sound: TimedSound, at: int, speed: float) -> int:
    """Append a sound that starts at a frame; return the frame where it ends."""
    end = at + _frames(sound[1] / speed)
    if end > at:
        rows.append(LabelRow(sound[0], at / VOICEVOX_FPS, end / VOICEVOX_FPS))
    return end


def _frames(seconds: float) -> int:
    """Round to whole frames, halves to even ones, as the engine does."""
    return round(seconds * VOICEVOX_FPS)


def _objects(source: TimingFile, whole: Json, name: str) -> list[Json]:
    what = f"needs lists of accent phrases and of moras; the form is {VOICEVOX_FORM}"
    # Each client of the engine has its own spelling of names.
    return [plain_fields(part) for part in source.object_list(whole.get(name), what)]


def _number(source: TimingFile, whole: Json, name: str, missing: float) -> float:
    """Return a length or a factor; only the pitch of no sound may be below 0."""
    value = whole.get(name)
    number = missing if value is None else source.number(value)
    if number < 0:
        raise source.fault(f"{name} is {number:g}; lengths and factors must be 0 or more")
    return number
