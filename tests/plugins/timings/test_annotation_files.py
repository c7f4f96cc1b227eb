"""Files of annotation tools and of voices: ELAN, SPPAS, EMU, VOICEVOX, aligners' JSON, Moho."""

import json
from dataclasses import replace

import numpy as np
import pytest
from timing_texts import spoken

import lipsync_lang as ll
from lipsync_lang.animations.animation import ExportSettings
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.plugins.programs.moho import SWITCH_FPS
from lipsync_lang.plugins.timings.moho import MOHO_FPS


def eaf(tiers, slots):
    """An .eaf; a slot of None has no time."""
    times = "".join(
        f'<TIME_SLOT TIME_SLOT_ID="ts{n}"' + (f' TIME_VALUE="{at}"/>' if at is not None else "/>")
        for n, at in enumerate(slots)
    )
    return f"<ANNOTATION_DOCUMENT>\n<TIME_ORDER>{times}</TIME_ORDER>\n{tiers}</ANNOTATION_DOCUMENT>"


def aligned(name, label, first, last):
    return (
        f'<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="{name}" TIME_SLOT_REF1="ts{first}" '
        f'TIME_SLOT_REF2="ts{last}"><ANNOTATION_VALUE>{label}</ANNOTATION_VALUE>'
        "</ALIGNABLE_ANNOTATION></ANNOTATION>"
    )


def referring(name, label, parent):
    return (
        f'<ANNOTATION><REF_ANNOTATION ANNOTATION_ID="{name}" ANNOTATION_REF="{parent}">'
        f"<ANNOTATION_VALUE>{label}</ANNOTATION_VALUE></REF_ANNOTATION></ANNOTATION>"
    )


def tier(name, *annotations, parent=""):
    ref = f' PARENT_REF="{parent}"' if parent else ""
    return f'<TIER TIER_ID="{name}"{ref}>{"".join(annotations)}</TIER>\n'


# ELAN


def test_elan_shares_time_evenly_where_slots_or_annotations_have_none(read):
    words = tier("words", aligned("w", "map", 0, 3))
    slots = (100, None, None, 400)
    inner = [aligned(f"p{n}", label, n, n + 1) for n, label in enumerate(("m", "a", "p"))]
    divided = read("line.eaf", eaf(words + tier("phones", *inner, parent="words"), slots))
    refs = [referring(f"p{n}", label, "w") for n, label in enumerate(("m", "a", "p"))]
    referred = read("line.eaf", eaf(words + tier("phones", *refs, parent="words"), slots))
    for schedule in (divided, referred):
        assert schedule.labels == ("_", "m", "a", "p")
        np.testing.assert_allclose(schedule.times, (0, 0.1, 0.2, 0.3, 0.4))
        assert spoken(schedule) == [("map", ("m", "a", "p"))]


def test_elan_says_what_has_no_time(read):
    text = eaf(tier("phones", aligned("a", "m", 0, 1), aligned("b", "a", 1, 2)), (0, 100, None))
    schedule = read("line.eaf", text)
    assert schedule.labels == ("m",)
    assert any("without a time are left out: 1" in told for told in schedule.remarks)


def test_elan_has_the_words_of_the_speaker_that_is_asked_for(read):
    tiers = "".join(
        tier(f"wd@{who}", aligned(f"w{who}", word, 0, 2))
        + tier(f"ph@{who}", aligned(f"p{who}", "m", 0, 1), aligned(f"q{who}", "a", 1, 2))
        for who, word in (("Ann", "ma"), ("Bob", "mar"))
    )
    text = eaf(tiers, (0, 100, 200))
    assert spoken(read("line.eaf", text, tier="Bob")) == [("mar", ("m", "a"))]
    with pytest.raises(ScheduleError, match="2 tiers look like phones: 'ph@Ann', 'ph@Bob'"):
        read("line.eaf", text)


def test_elan_in_a_loop_is_refused_where_it_stands(read):
    text = eaf(tier("phones", parent="words") + tier("words", parent="phones"), ())
    with pytest.raises(ScheduleError, match=r"line.eaf:3: tier 'phones' is its own parent"):
        read("line.eaf", text)
    text = eaf(tier("phones", referring("a", "m", "b"), "\n", referring("b", "a", "a")), ())
    with pytest.raises(ScheduleError, match=r"line.eaf:3: annotation 'a' refers to itself"):
        read("line.eaf", text)


# SPPAS


def test_sppas_takes_what_has_the_highest_score_in_its_old_form(read):
    place = (
        '<Localization score="{}"><Timeinterval><Begin midpoint="{}"/><End midpoint="{}"/>'
        "</Timeinterval></Localization>"
    )
    schedule = read(
        "line.xra",
        '<Document Author="SPPAS" Format="1.2"><Media id="m"><Tier id="t"/></Media>'
        '<Tier id="t" tiername="PhonAlign"><Annotation><Location>'
        + place.format(1.0, 0.1, 0.2)
        + '</Location><Label><Text score="0.2">b</Text><Text score="0.8">m</Text></Label>'
        "</Annotation></Tier></Document>",
    )
    assert schedule.labels == ("_", "m")
    np.testing.assert_allclose(schedule.times, (0, 0.1, 0.2))


# EMU


def emu(links, word="Word"):
    return {
        "sampleRate": 1000,
        "levels": [
            {
                "name": word,
                "type": "ITEM",
                "items": [
                    {
                        "id": 1,
                        "labels": [{"name": word, "value": "C"}, {"name": "Text", "value": "ma"}],
                    }
                ],
            },
            {"name": "Syllable", "type": "ITEM", "items": [{"id": 2, "labels": []}]},
            {
                "name": "Phonetic",
                "type": "SEGMENT",
                "items": [
                    {
                        "id": 3 + n,
                        "sampleStart": 100 * n,
                        "sampleDur": 99,
                        "labels": [{"name": "Phonetic", "value": label}],
                    }
                    for n, label in enumerate("ma")
                ],
            },
        ],
        "links": [{"fromID": one, "toID": other} for one, other in links],
    }


def test_emu_words_are_spelled_by_their_text_and_timed_through_their_syllables(read):
    schedule = read("line_annot.json", emu([(1, 2), (2, 3), (2, 4)]))
    assert schedule.labels == ("m", "a")
    np.testing.assert_allclose(schedule.times, (0, 0.1, 0.2))
    assert spoken(schedule) == [("ma", ("m", "a"))]
    with pytest.raises(ScheduleError, match="links lead from item 1 back to itself; remove one"):
        read("line_annot.json", emu([(1, 2), (2, 1)]))


# VOICEVOX


def query(**fields):
    mora = {"text": "マ", "consonant": "m", "consonant_length": 0.064, "vowel": "a"}
    mora |= {"vowel_length": 0.128, "pitch": 5.0}
    pause = {"text": "、", "consonant": None, "vowel": "pau", "vowel_length": 0.32, "pitch": 0}
    phrase = {"moras": [mora], "accent": 1, "pause_mora": None, "is_interrogative": False}
    whole = {"accent_phrases": [phrase | {"pause_mora": pause}, phrase], "speedScale": 1.0}
    return whole | {"prePhonemeLength": 0.096, "postPhonemeLength": 0.096} | fields


def test_voicevox_is_timed_as_the_engine_speaks_it(read):
    schedule = read("line.json", query())
    assert schedule.labels == ("_", "m", "a", "_", "m", "a", "_")
    frames = np.cumsum([0, 9, 6, 12, 30, 6, 12, 9])
    np.testing.assert_allclose(schedule.times, frames / 93.75)
    assert [word.text for word in schedule.words] == ["マ", "マ"]
    halved = read("line.json", query(speedScale=2.0, pauseLength=0.64, pauseLengthScale=0.5))
    # a sound of 3 frames stays one, and 4.5 frames become 4: halves go to even numbers
    np.testing.assert_allclose(halved.times, np.cumsum([0, 4, 3, 6, 15, 3, 6, 4]) / 93.75)


def test_voicevox_lengthens_a_question_and_refuses_what_has_no_lengths(read):
    asked = query()
    asked["accent_phrases"][1]["is_interrogative"] = True
    assert read("line.json", asked).labels[-3:] == ("a", "a", "_")
    for phrase in asked["accent_phrases"]:
        phrase["moras"] = [{"text": "マ", "consonant": "m", "vowel": "a"}]
    told = read(
        "line.json", {"accent_phrases": [*query()["accent_phrases"], *asked["accent_phrases"]]}
    )
    assert any("half a frame are ignored: 4" in one for one in told.remarks)
    with pytest.raises(ScheduleError, match="no lengths of sounds; ask the engine for an audio_qu"):
        read("line.json", asked)
    with pytest.raises(ScheduleError, match="speedScale must be above 0"):
        read("line.json", query(speedScale=0))
    with pytest.raises(ScheduleError, match="prephonemelength is -1; lengths and factors"):
        read("line.json", query(prePhonemeLength=-1))


# Aligners' JSON


def test_a_sound_of_bournemouth_without_ipa_has_its_label(read):
    phones = [
        {"ipa_label": "overflow", "phoneme_label": "m", "start_ms": 0, "end_ms": 100},
        {"ipa_label": "ɑ", "phoneme_label": "a", "start_ms": 100, "end_ms": 200},
    ]
    found = read("line.json", {"segments": [{"phoneme_ts": phones, "words_ts": []}]})
    assert found.labels == ("m", "ɑ")


def test_bournemouth_sounds_last_until_the_next_one_of_their_word(read):
    sounds = [("b", 33, 50), ("ʌ", 100, 117), ("m", 400, 450)]
    schedule = read(
        "line.json",
        {
            "segments": [
                {
                    "phoneme_ts": [
                        {"phoneme_label": label, "start_ms": at, "end_ms": end}
                        for label, at, end in sounds
                    ],
                    "words_ts": [
                        {"word": "bu", "start_ms": 33, "end_ms": 117},
                        {"word": "m", "start_ms": 400, "end_ms": 450},
                    ],
                }
            ]
        },
    )
    assert schedule.labels == ("_", "b", "ʌ", "_", "m")
    np.testing.assert_allclose(schedule.times, (0, 0.033, 0.1, 0.117, 0.4, 0.45))
    assert spoken(schedule) == [("bu", ("b", "ʌ")), ("m", ("m",))]
    assert any("each sound is extended to the next" in told for told in schedule.remarks)


def test_charsiu_may_have_phones_alone(read):
    schedule = read("line.json", [[0.0, 0.1, "[SIL]"], [0.1, 0.2, "M"]])
    assert schedule.labels == ("[SIL]", "M")
    with pytest.raises(ScheduleError, match="needs lists of start, end and label; the form is"):
        read("line.json", [[0.0, 0.1, "M"], "M"])


# Moho and Azure


def test_moho_says_which_rate_it_takes_and_which_shapes_it_has(read):
    schedule = read("line.dat", "MohoSwitch1\n1 rest\n4 MBP\n7 AI\n13 rest\n")
    np.testing.assert_allclose(schedule.times, (0, 3 / 24, 6 / 24, 12 / 24))
    assert schedule.notation == "preston-blair"
    assert any("24 frames per second are assumed" in told for told in schedule.remarks)
    assert read("line.dat", "MohoSwitch1\n1 X\n4 A\n9 X\n").notation == "rhubarb"
    with pytest.raises(ScheduleError, match=r"line.dat:3: 'four MBP' is not a frame and a drawing"):
        read("line.dat", "MohoSwitch1\n1 rest\nfour MBP\n")


def test_moho_is_written_at_the_rate_at_which_it_is_read(tmp_path):
    assert SWITCH_FPS == MOHO_FPS
    usual = ll.resolve("english", "rhubarb").perform(ll.Schedule(("M", "AA1"), (0, 0.5, 2)))
    stated = replace(usual, export=ExportSettings(frame_rate=60))
    usual.save(tmp_path / "line.dat")
    stated.save(tmp_path / "fine.dat")
    assert ll.read_schedule(tmp_path / "line.dat").end == pytest.approx(2, abs=0.1)
    assert ll.read_schedule(tmp_path / "fine.dat", rate=60).end == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(
    ("offset", "viseme", "factor", "unit"),
    [
        ("AudioOffset", "VisemeId", 1e7, None),
        ("audioOffset", "visemeId", 1e7, None),
        ("audioOffsetMs", "viseme_id", 1e3, "milliseconds"),
        ("audio_offset", "VisemeID", 1, "seconds"),
    ],
)
def test_azure_counts_in_the_unit_that_its_offsets_are_in(read, offset, viseme, factor, unit):
    starts = ((0, 0.05), (19, 0.1), ("6", 0.2), (0, 0.35))
    events = [{offset: round(at * factor, 3), viseme: number} for number, at in starts]
    schedule = read("line.json", events)
    np.testing.assert_allclose(schedule.times, (0, 0.05, 0.1, 0.2, 0.35))
    assert schedule.labels == ("_", "0", "19", "6")
    told = [remark for remark in schedule.remarks if "its offsets are read as" in remark]
    assert [unit] * len(told) == [remark.split(";")[0].split()[-1] for remark in told]
    assert bool(told) == (unit is not None)


# XML


def test_xml_may_name_a_type_and_an_encoding_but_declare_nothing(read):
    body = eaf(tier("phones", aligned("a", "é", 0, 1)), (0, 100))
    head = (
        '<?xml version="1.0" encoding="ISO-8859-1"?>\n<!DOCTYPE ANNOTATION_DOCUMENT SYSTEM "x">\n'
    )
    assert read("line.eaf", (head + body).encode("latin-1")).labels == ("é",)
    bad = head.replace(' "x">', ' "x" [<!ENTITY e "m">]>')
    with pytest.raises(ScheduleError, match="eaf:2: has a <!DOCTYPE>, which is never read"):
        read("line.eaf", (bad + body).encode("latin-1"))


# Voices and recognisers


def test_mbrola_counts_what_lasts_and_locates_what_is_no_phoneme(read):
    schedule = read("line.pho", "; a comment\n_ 100\nh 50 0 120 (50,118)\n@ 0\n#\nU 100.5\n")
    assert schedule.labels == ("_", "h", "U")
    np.testing.assert_allclose(schedule.times, (0, 0.1, 0.15, 0.2505))
    with pytest.raises(ScheduleError, match=r"line.pho:3: 'U long' is not a phoneme and a dur"):
        read("line.pho", "h 50\n_ 50\nU long\n")


def test_answers_of_a_stream_are_read_together(read):
    times = {"phonemes": ["m"], "start": [0.0], "end": [0.1]}
    later = {"phonemes": ["a"], "start": [0.1], "end": [0.3]}
    answers = [
        {"type": "chunk", "data": "UklGRg=="},
        {"type": "phoneme_timestamps", "phoneme_timestamps": times},
        {"type": "phoneme_timestamps", "phoneme_timestamps": later},
        {"word_timestamps": {"words": ["ma"], "start": [0.0], "end": [0.3]}},
    ]
    schedule = read("line.jsonl", "\n".join(map(json.dumps, answers)))
    assert spoken(schedule) == [("ma", ("m", "a"))]
    np.testing.assert_allclose(schedule.times, (0, 0.1, 0.3))
    later["end"] = []
    with pytest.raises(ScheduleError, match=r"line.jsonl:3: needs three lists of one length"):
        read("line.jsonl", "\n".join(map(json.dumps, answers)))


@pytest.mark.parametrize(
    "document",
    [
        {"phoneme_timestamps": {"phonemes": [], "start": [], "end": []}, "word_timestamps": {
            "words": ["ma"], "start": [0.1], "end": [0.3]}},
        {"result": {"timestampInfo": {"wordAlignment": {"words": ["ma", "!"],
            "wordStartTimeSeconds": [0.1, 0.3], "wordEndTimeSeconds": [0.3, 0.3]}}}},
        {"NBest": [{"Words": [{"Word": "ma", "Offset": 1000000, "Duration": 2000000}]}, {}]},
    ],
)  # fmt: skip
def test_answers_without_phonemes_time_words(document, tmp_path):
    path = tmp_path / "line.json"
    path.write_text(json.dumps(document), "utf-8")
    (word,) = ll.read_timings(path).words
    assert (word.text, word.start, word.end) == ("ma", 0.1, 0.3)
