"""Chinese text in pinyin: readings, other text among hanzi, and unreadable text."""

import csv
from collections import Counter

import pytest
from lanes import full
from shipped import LIBRARY

from lipsync_lang import SpeechError, read_schedule, resolve
from lipsync_lang.sound.speech.speaking.speaker import speak, transcribe
from lipsync_lang.text.phonology.g2p import Settings, SpokenWord, engine
from lipsync_lang.text.phonology.g2p import pinyin as module
from lipsync_lang.text.phonology.g2p.g2p_engines import Rule
from lipsync_lang.text.phonology.labels import Notation, recognise

pytest.importorskip("pypinyin", reason="pypinyin is not installed")
pytest.importorskip("opencc", reason="OpenCC is not installed")

PACK = LIBRARY.language("mandarin").model
LABELS = PACK.notations["pinyin"]
READINGS = tuple(Rule(r.spelling, r.to, r.before, r.after) for r in PACK.g2p.readings)
SETTINGS = Settings(PACK.name, labels=tuple(LABELS), readings=READINGS)


@pytest.fixture(scope="module")
def read():
    """The engine without the numbers of the pack, and without another voice."""
    make = engine("pypinyin", SETTINGS)
    return lambda text: next(iter(make([text])))


@pytest.fixture(scope="module")
def heard(read):
    """Return the labels of a text, with words between slashes, and punctuation for pauses."""
    return lambda text: " / ".join(" ".join(word.labels) or word.text for word in read(text))


@pytest.fixture(scope="module")
def voiced(read):
    """Input of the voice for a text."""
    return lambda text: " ".join(word.respelled for word in read(text) if word.labels)


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("我", "uo"),
        ("月", "üe"),
        ("有", "iou"),
        ("五", "u"),
        ("雨", "ü"),
        ("问", "uen"),
        ("用", "iong"),
        ("会", "h uei"),
        ("六", "l iou"),
        ("学", "x üe"),
        ("军", "j ün"),
        ("女", "n ü"),
        ("略", "l üe"),
        ("是", "sh i"),
        ("二", "er"),
        ("嗯", "n"),
        ("哟", "i o"),
    ],
)
def test_finals_are_whole_and_start_a_syllable_as_they_are(heard, text, labels):
    assert heard(text) == labels


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("银行", "in h ang"),
        ("行走", "x ing z ou"),
        ("重要", "zh ong iao"),
        ("重复", "ch ong f u"),
        ("校长", "x iao zh ang"),
        ("很长", "h en / ch ang"),
        ("长大了", "zh ang d a / l e"),
        ("了解", "l iao j ie"),
        ("音乐", "in üe"),
        ("快乐", "k uai l e"),
        ("睡觉", "sh uei j iao"),
        ("觉得", "j üe d e"),
        ("还有", "h ai / iou"),
        ("归还", "g uei h uan"),
        ("草地", "c ao d i"),
        ("慢慢地走", "m an / m an / d e / z ou"),
    ],
)
def test_characters_of_several_readings_are_read_by_their_word(heard, text, labels):
    assert heard(text) == labels


@pytest.mark.parametrize(
    ("traditional", "simplified"),
    [
        ("銀行", "银行"),
        ("重慶", "重庆"),
        ("長髮", "长发"),
        ("音樂", "音乐"),
        ("瞭解", "了解"),
        ("我還沒睡覺", "我还没睡觉"),
        ("看著我", "看着我"),
        ("著名", "著名"),
        ("一點兒", "一点儿"),
        ("女兒", "女儿"),
    ],
)
def test_traditional_characters_are_read_and_kept(read, heard, traditional, simplified):
    assert heard(traditional) == heard(simplified)
    assert "".join(word.text for word in read(traditional)) == traditional


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("花儿", "h ua r"),
        ("一点儿", "i d ian r"),
        ("这儿", "zh e r"),
        ("聊天儿", "l iao / t ian r"),
        ("一会儿时间", "i h uei r / sh i j ian"),
        ("女儿", "n ü er"),
        ("儿子", "er z i"),
        ("婴儿", "ing / er"),
    ],
)
def test_an_r_after_a_syllable_is_one_and_a_child_is_a_syllable(heard, text, labels):
    assert heard(text) == labels


def test_tones_are_the_voices_alone(read):
    (word,) = read("我们")
    assert word == SpokenWord("我们", ("uo", "m", "en"), "wo3men5")


def test_syllables_that_the_voice_does_not_know_are_spelled_round_it(voiced):
    assert voiced("熊 穷 窘 呣 嗯 花儿") == "xi2ong2 qi2ong2 ji3ong3 mu2 n2 hua1er5"


@pytest.mark.parametrize("text", ["lǜ", "lü4", "lv4", "lu:4", "LÜ4", "Lǜ", "lü\u0300"])
def test_all_spellings_of_a_rounded_i_are_read(heard, voiced, text):
    assert heard(text) == "l ü"
    assert voiced(text) == "lv4"


@pytest.mark.parametrize(
    ("text", "labels", "voice"),
    [
        ("nǐ hǎo", "n i / h ao", "ni3 hao3"),
        ("ni3hao3", "n i h ao", "ni3hao3"),
        ("Ｎｉ３ hao3", "n i / h ao", "ni3 hao3"),
        ("māma", "m a m a", "ma1ma5"),
        ("xī'ān", "x i an", "xi1an1"),
        ("xiān", "x ian", "xian1"),
        ("fāngàn", "f an g an", "fan1gan4"),
        ("fāng'àn", "f ang an", "fang1an4"),
        ("tiāné", "t ian e", "tian1e2"),
        ("huār", "h ua r", "hua1er5"),
        ("hua1r", "h ua r", "hua1er5"),
        ("huar1", "h ua r", "hua1er5"),
        ("èr", "er", "er4"),
        ("xüé", "x üe", "xue2"),
        ("zhongguo", "zh ong g uo", "zhong1guo1"),
        ("women", "uo m en", "wo1men1"),
    ],
)
def test_pinyin_is_read_as_it_is_spelled(heard, voiced, text, labels, voice):
    assert heard(text) == labels
    assert voiced(text) == voice


def test_words_without_tones_are_pinyin_only_where_no_hanzi_stand(heard):
    assert heard("can") == "c an"
    assert heard("三ge") == "s an / g e"
    assert heard("我can") == "uo / can"
    assert heard("我cān") == "uo / c an"
    assert heard("A4纸") == "A / s i / zh i"


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("0", "零"),
        ("10", "十"),
        ("12", "十二"),
        ("110", "一百一十"),
        ("1010", "一千零一十"),
        ("10500", "一万零五百"),
        ("20005", "两万零五"),
        ("22000", "两万二千"),
        ("100000", "十万"),
        ("101000", "十万一千"),
        ("10000000", "一千万"),
        ("100000010", "一亿零一十"),
        ("105000000", "一亿零五百万"),
        ("123456789", "一亿二千三百四十五万六千七百八十九"),
        ("1,234,567", "一百二十三万四千五百六十七"),
        ("9999999999", "九十九亿九千九百九十九万九千九百九十九"),
        ("2个", "两个"),
        ("2月", "二月"),
        ("2:02", "两点零二分"),
        ("2024年", "二零二四年"),
        ("2024人", "两千零二十四人"),
        ("30年", "三十年"),
        ("3.14", "三点一四"),
        ("2,3", "二三"),
        ("-5", "负五"),
        ("12%", "百分之十二"),
        ("1.5‰", "千分之一点五"),
        ("007", "零零七"),
        ("3点05分", "三点零五分"),
        ("13812345678", "幺三八幺二三四五六七八"),
        ("第XX届", "第二十届"),
        ("1+1=2", "一加一等于二"),
    ],
)
def test_numbers_are_read_as_chinese_reads_them(written, said):
    found, expected = transcribe([written, said], PACK.name)
    assert found.phonemes == expected.phonemes
    assert not found.unread


def test_a_digit_behind_letters_is_a_tone_where_they_are_pinyin():
    toned, numbered = transcribe(["ni3hao3", "MP3吧"], PACK.name)
    assert toned.words[0].respelled == "ni3hao3"
    assert [word.respelled for word in numbered.words] == ["MP", "san1", "ba5"]


def test_digits_that_the_pack_leaves_are_read_one_by_one(heard):
    assert heard("12") == "i er"


def test_numbers_of_any_length_are_read():
    texts = [text for n in range(1, 40) for text in ("9" * n, "1" + ",000" * n)]
    assert all(found.labels and not found.unread for found in transcribe(texts, PACK.name))


def test_numbers_among_hanzi_are_words_of_their_own():
    (found,) = transcribe(["2024年有123个,涨3.5%"], PACK.name)
    assert [word.text for word in found.words] == ["2024年", "有", "123", "个", ",", "涨", "3.5%"]
    assert found.words[2].labels == ("i", "b", "ai", "er", "sh", "-i", "s", "an")


@full
def test_foreign_words_are_said_as_another_voice_says_them():
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    text = "我爱Sylvie，用iPad15和café，T恤，OK！"
    (found,) = transcribe([text], PACK.name)
    words = {word.text: word for word in found.words}
    assert words["Sylvie"].labels == ("s", "ɪ", "l", "f", "i")
    assert words["T"].labels == ("t", "iː")
    assert words["OK"].labels == ("əʊ", "k", "eɪ")
    assert words["café"].respelled == "cafe"
    assert not found.unmapped
    assert not found.unread


@full
def test_every_sound_of_english_words_is_mapped(data):
    pytest.importorskip("espeakng_loader", reason="the speech extra is not installed")
    lines = (data / "text" / "harvard-sentences.txt").read_text("utf-8").splitlines()
    words = sorted({word.strip(".,'").casefold() for line in lines for word in line.split()})
    (found,) = transcribe(["我" + " ".join(words)], PACK.name)
    assert not found.unmapped
    assert not found.unread


def test_punctuation_rests_and_quotes_do_not(read):
    words = read("「你好」，《世》·（界）……好～吗？")
    assert [word.text for word in words] == ["你好", "，", "世", "界", "……", "好", "吗", "？"]
    assert [word.text for word in words if not word.labels] == ["，", "……", "？"]
    assert not any(word.unread for word in words)
    assert read(" 。") == (SpokenWord("。", ()),)
    assert read("") == ()


def test_what_is_no_chinese_is_named_and_not_sent_to_the_voice(read):
    words = read("你好か😀々★ж")
    assert [word.unread for word in words if word.unread] == ["か", "😀", "々", "★", "ж"]
    assert {word.respelled for word in words if word.unread} == {" "}
    assert "".join(word.text for word in words) == "你好か😀々★ж"


def test_what_is_no_chinese_at_all_is_refused_by_its_name():
    with pytest.raises(SpeechError, match="cannot read か な"):
        speak("かな", PACK.name, engine="none")


def test_a_missing_library_says_what_to_install(monkeypatch):
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    with pytest.raises(SpeechError, match=r'pip install "lipsync-lang\[mandarin\]"'):
        engine("pypinyin", Settings(PACK.name))


def test_a_long_run_of_letters_is_read(read):
    for letters in ("xian" * 14 + "q", "nanga" * 12, "a" * 5000, "ang" * 20):
        assert "".join(word.text for word in read(letters)) == letters


def test_every_syllable_that_pypinyin_knows_is_mapped():
    from pypinyin.constants import PHRASES_DICT, PINYIN_DICT
    from pypinyin.contrib.tone_convert import to_tone3

    sounds = {s for readings in PINYIN_DICT.values() for s in readings.split(",")}
    sounds |= {s for phrase in PHRASES_DICT.values() for readings in phrase for s in readings}
    syllables = {to_tone3(s, neutral_tone_with_five=True) for s in sounds}
    assert len(syllables) > 1000
    labels = {label for syllable in syllables for label in module.labels_of(syllable)}
    assert labels <= set(LABELS)


def lines_of(data):
    """Whole texts and dialogue, simplified and traditional."""
    for name in ("cmn_hans", "cmn_hant"):
        yield from (data / "text" / "udhr" / f"{name}.txt").read_text("utf-8").splitlines()
    with (data / "text" / "the_question_lines.tsv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE):
            yield from (row["schinese"], row["tchinese"])


@full
def test_whole_texts_are_read_without_a_gap(data):
    texts = [line for line in lines_of(data) if line.strip()]
    assert len(texts) > 200
    unmapped, unread, labels = Counter(), Counter(), 0
    for found in transcribe(texts, PACK.name):
        unmapped.update(found.unmapped)
        unread.update(found.unread)
        labels += len(found.labels)
    assert not unmapped
    assert not unread
    assert labels > 10_000


def test_what_an_aligner_writes_is_recognised_and_mapped(data):
    """Labels with tones are read, and so is the notation that splits finals before n and ng."""
    spoken = read_schedule(data / "alignments" / "mandarin_mfa" / "774.TextGrid")
    notations = {
        name: Notation({label: s.to for label, s in table.items()})
        for name, table in PACK.notations.items()
    }
    labels = [label for label in spoken.labels if label not in {"_", "", "sil", "sp"}]
    assert len(labels) > 50
    assert recognise(labels, notations) == "mfa-pinyin"
    assert not [label for label in labels if notations["mfa-pinyin"].find(label) is None]


def test_it_shares_what_english_has_and_adds_one_phoneme():
    """Section 5.4 of the paper on Mandarin: one more phoneme, 43 more bigrams."""
    report = resolve(PACK.name, "facefx").report
    assert (report.shared, report.extra) == (441, 43)
    assert set(PACK.adds) == {"yu"}


def test_a_mark_at_the_end_is_no_pause():
    (heard,) = transcribe(["你好，你好。"], "mandarin")
    assert heard.phonemes.count("_") == 1
    assert heard.phonemes[-1] == "aw"
    assert heard.words[-1].text == "你好"
