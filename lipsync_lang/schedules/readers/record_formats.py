"""Formats of timings in JSON that differ in their paths and the names of their fields alone."""

from lipsync_lang.schedules.records import RecordFormat, RecordList
from lipsync_lang.schedules.timing_readers import TIMING_READERS

RECORD_FORMATS = (
    RecordFormat(
        "aws-transcribe",
        "Words that Amazon Transcribe has recognised.",
        # Punctuation stands among the words, without times.
        words=RecordList(
            "alternatives[0].content",
            "start_time",
            "results.items",
            end="end_time",
            untimed=True,
            speaker="speaker_label",
        ),
        form='{"results": {"items": [{"type": "pronunciation", "start_time": "0.1", "end_time": '
        '"0.62", "alternatives": [{"content": "maps"}]}]}}',
    ),
    RecordFormat(
        "azure-recognition",
        "Words that Azure has recognised, with phonemes where it has assessed their pronunciation.",
        mentions=("NBest",),
        # The first of several readings of the sound is the best.
        words=RecordList("Word", "Offset", "NBest[0].Words", duration="Duration", unnamed=True),
        # Languages without names of phonemes have their times alone.
        phonemes=RecordList(
            "Phoneme", "Offset", "NBest[0].Words.Phonemes", duration="Duration", unnamed=True
        ),
        unit="ticks",
        form='{"NBest": [{"Words": [{"Word": "maps", "Offset": 1000000, "Duration": 5200000, '
        '"Phonemes": [{"Phoneme": "m", "Offset": 1000000, "Duration": 900000}]}]}]}',
    ),
    RecordFormat(
        "cartesia",
        "Times of phonemes and words that Cartesia gives with its speech.",
        mentions=("phoneme_timestamps", "word_timestamps"),
        phonemes=RecordList("phonemes", "start", "phoneme_timestamps", end="end", columns=True),
        words=RecordList("words", "start", "word_timestamps", end="end", columns=True),
        form='{"phoneme_timestamps": {"phonemes": ["m"], "start": [0.1], "end": [0.19]}}',
    ),
    RecordFormat(
        "deepgram",
        "Words that Deepgram has recognised.",
        words=RecordList(
            "word", "start", "results.channels.alternatives[0].words", end="end", speaker="speaker"
        ),
        form='{"results": {"channels": [{"alternatives": [{"words": [{"word": "maps", "start": '
        '0.1, "end": 0.62}]}]}]}}',
    ),
    RecordFormat(
        "edge-tts",
        "Boundaries of words or sentences that edge-tts gives with its speech.",
        words=RecordList("text", "offset", duration="duration"),
        unit="ticks",
        form='{"type": "WordBoundary", "offset": 1000000, "duration": 5200000, "text": "maps"}',
    ),
    RecordFormat(
        "gladia",
        "Words that Gladia has recognised.",
        words=RecordList(
            "word",
            "start",
            "result.transcription.utterances.words | transcription.utterances.words",
            end="end",
            speaker="speaker",
        ),
        form='{"result": {"transcription": {"utterances": [{"words": [{"word": "maps", "start": '
        '0.1, "end": 0.62}]}]}}}',
    ),
    RecordFormat(
        "google",
        "Words that Google's speech-to-text has recognised, version 1.",
        words=RecordList(
            "word",
            "startTime|start_time",
            "results.alternatives[0].words | response.results.alternatives[0].words",
            end="endTime|end_time",
            from_zero=True,
            speaker="speakerTag|speaker_tag|speakerLabel|speaker_label",
        ),
        form='{"results": [{"alternatives": [{"words": [{"word": "maps", "startTime": "0.100s", '
        '"endTime": "0.620s"}]}]}]}',
    ),
    RecordFormat(
        "google-v2",
        "Words that Google's speech-to-text has recognised, version 2.",
        words=RecordList(
            "word",
            "startOffset|start_offset",
            "results.alternatives[0].words",
            end="endOffset|end_offset",
            from_zero=True,
            speaker="speakerLabel|speaker_label",
        ),
        form='{"results": [{"alternatives": [{"words": [{"word": "maps", "startOffset": "0.100s", '
        '"endOffset": "0.620s"}]}]}]}',
    ),
    RecordFormat(
        "google-timepoints",
        "Marks of SSML that Google's text-to-speech times; each mark is the word after it.",
        words=RecordList("markName", "timeSeconds", "timepoints"),
        form='{"timepoints": [{"markName": "maps", "timeSeconds": 0.1}]}',
    ),
    RecordFormat(
        "inworld",
        "Times of words and phones that Inworld gives with its speech.",
        mentions=("timestampInfo",),
        phonemes=RecordList(
            "phoneSymbol",
            "startTimeSeconds",
            "result.timestampInfo.wordAlignment.phoneticDetails.phones"
            " | timestampInfo.wordAlignment.phoneticDetails.phones",
            duration="durationSeconds",
        ),
        words=RecordList(
            "words",
            "wordStartTimeSeconds",
            "result.timestampInfo.wordAlignment | timestampInfo.wordAlignment",
            end="wordEndTimeSeconds",
            columns=True,
        ),
        form='{"timestampInfo": {"wordAlignment": {"words": ["maps"], "wordStartTimeSeconds": '
        '[0.1], "wordEndTimeSeconds": [0.62], "phoneticDetails": [{"wordIndex": 0, "phones": '
        '[{"phoneSymbol": "m", "startTimeSeconds": 0.1, "durationSeconds": 0.09}]}]}}}',
    ),
    RecordFormat(
        "kokoro",
        "Characters of phonemes that kokoro-onnx times (`create_timed`).",
        phonemes=RecordList("phoneme", "start", end="end"),
        characters=True,
        form='[{"phoneme": "m", "start": 0.1, "end": 0.19}]',
    ),
    RecordFormat(
        "kokoro-tokens",
        "Words that Kokoro times; their phonemes have no times.",
        # Punctuation may have no times.
        words=RecordList("text", "start_ts", "tokens | ", end="end_ts", untimed=True),
        form='[{"text": "maps", "phonemes": "mˈæps", "start_ts": 0.1, "end_ts": 0.62}]',
    ),
    RecordFormat(
        "piper",
        "Characters of phonemes that Piper's server times.",
        phonemes=RecordList("phoneme", None, "alignments | ", duration="seconds"),
        characters=True,
        form='{"alignments": [{"phoneme": "m", "seconds": 0.09}]}',
    ),
    RecordFormat(
        "piper-samples",
        "Characters of phonemes that Piper times in samples, at 22.05 kHz unless `rate` is stated.",
        phonemes=RecordList(
            "phoneme", None, "phoneme_alignments | alignments | ", duration="num_samples"
        ),
        rate=22050,
        characters=True,
        form='[{"phoneme": "m", "phoneme_ids": [25, 0], "num_samples": 1984}]',
    ),
    RecordFormat(
        "rev",
        "Words that Rev has recognised.",
        words=RecordList(
            "value", "ts", "monologues.elements", end="end_ts", untimed=True, speaker="speaker"
        ),
        form='{"monologues": [{"elements": [{"type": "text", "value": "maps", "ts": 0.1, '
        '"end_ts": 0.62}]}]}',
    ),
    RecordFormat(
        "speechmatics",
        "Words that Speechmatics has recognised.",
        words=RecordList(
            "alternatives[0].content",
            "start_time",
            "results",
            end="end_time",
            speaker="alternatives[0].speaker",
        ),
        form='{"results": [{"type": "word", "start_time": 0.1, "end_time": 0.62, "alternatives": '
        '[{"content": "maps"}]}]}',
    ),
    RecordFormat(
        "talking-head",
        "Visemes and words of TalkingHead and HeadTTS.",
        phonemes=RecordList("visemes", "vtimes", duration="vdurations", columns=True),
        words=RecordList("words", "wtimes", duration="wdurations", columns=True),
        unit="ms",
        notation="oculus",
        shapes=True,
        form='{"visemes": ["U"], "vtimes": [100], "vdurations": [90], "words": ["maps"], '
        '"wtimes": [100], "wdurations": [520]}',
    ),
    RecordFormat(
        "word-times",
        "Words with `start_time` and `end_time`, as NeMo, Kokoro-FastAPI and others write them.",
        words=RecordList(
            "word", "start_time", "words | timestamps | word_timestamps | ", end="end_time"
        ),
        form='{"words": [{"word": "maps", "start_time": 0.1, "end_time": 0.62}]}',
    ),
)

for one in RECORD_FORMATS:
    TIMING_READERS.add(one.name, one.reader(), __name__)
