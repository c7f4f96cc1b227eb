"""Japanese text in kana: readings, grouping, and unreadable text."""

import re
import sys

import pytest
from lanes import full

from lipsync_lang import SpeechError
from lipsync_lang.plugins.g2p.kana import MAX_READ_CHARS, dictionary, respell
from lipsync_lang.sound.speech.speaking.speaker import Speaker

needs_dictionary = pytest.mark.skipif(
    "not __import__('importlib.util').util.find_spec('pyopenjtalk')",
    reason="pyopenjtalk-plus is not installed",
)


def read(text):
    """Return only the spellings, between slashes."""
    return "/".join(spelling for _, spelling in respell(text))


@needs_dictionary
@pytest.mark.parametrize(
    ("word", "kana"),
    [
        ("konnichiwa", "コンニチワ"), ("Shinjuku", "シンジュク"), ("gakkou", "ガッコー"),
        ("Satō", "サトー"), ("matcha", "マッチャ"), ("shimbun", "シンブン"),
        ("ryūjin", "リュージン"),
        ("strategy", "ストラタジ"), ("Photoshop", "フォートーショップ"), ("Twitch", "トウィッチ"),
        ("DVD", "ディーブイディー"),
    ],
)  # fmt: skip
def test_romaji_is_read_by_its_syllables_and_english_by_its_sounds(word, kana):
    (one,) = Speaker.of("japanese").transcribe([word])
    assert re.sub("[a-z]", "", "".join(one.labels)) == kana


@needs_dictionary
@pytest.mark.parametrize(
    ("text", "kana"),
    [
        ("私は東京へ行きました", "ワタシ/ワ/トーキョー/エ/イキマシ̥タ"),
        ("水を買わなくてはならない", "ミズ/オ/カワナク̥テ/ワ/ナラナイ"),
        ("こんにちは", "コンニチワ"),
        ("そう言うと、王様は笑った。", "ソー/ユー/ト/、/オーサマ/ワ/ワラッタ/。"),
        ("一本、二本、三本", "イッポン/、/ニホン/、/サンボン"),
        ("大人二人と子供四人", "オトナ/フタリ/ト/コドモ/ヨニン"),
        ("続き", "ツズキ"),
    ],
)
def test_words_are_spelled_as_they_sound(text, kana):
    assert read(text) == kana


@needs_dictionary
@pytest.mark.parametrize(
    ("text", "kana"),
    [
        ("2024年12月3日", "ニセンニジューヨネン/ジューニガツ/ミッカ"),
        ("10,000円", "イチマンエン"),
        ("3.14", "サンテンイチヨン"),
        ("午後4時30分", "ゴゴ/ヨジ/サンジュップン"),
        ("１００％", "ヒャク̥パーセント"),
        ("三百六十五日", "サンビャクロクジューゴニチ"),
    ],
)
def test_numbers_are_read_with_their_counters(text, kana):
    assert read(text) == kana


@needs_dictionary
@pytest.mark.parametrize(
    ("text", "kana"),
    [
        ("NHKのニュース", "エヌエイチケイ/ノ/ニュース"),
        ("Windowsとメール", "ウィンドーズ/ト/メール"),
        ("qwxz", "キューダブリューエックスゼット"),
    ],
)
def test_latin_words_are_read_in_kana_or_letter_by_letter(text, kana):
    assert read(text) == kana


@needs_dictionary
@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "。",
        "！？!!",
        "ーーー",
        "今日は\n\n  明日も　です\r\n",
        "「えっ!?」…ええと——ねえ〜。",
        "か\u3099き\u3099、ｶﾞｷﾞ、①㈱㌔、㍻",
        "한국어とไทยとПривет、😀とα",
        "今\x00日\u200bは",
        "\x00",
        "¥500と-5度、1/2、090-1234-5678",
        "ア" * 5 + "\ud800",
    ],
)
def test_the_pieces_make_up_the_text_again(text):
    assert "".join(piece for piece, _ in respell(text)) == text


@needs_dictionary
@pytest.mark.parametrize("text", ["はーい、えーと。", "ありがとー！"])
def test_a_wave_dash_draws_a_vowel_out(text):
    said = [spelling for _, spelling in respell(text)]
    for wave in "~〜～":
        assert [spelling for _, spelling in respell(text.replace("ー", wave))] == said


@needs_dictionary
def test_what_cannot_be_read_keeps_its_spelling_to_be_named():
    assert ("한국어", "한국어") in respell("한국어と日本語")
    assert ("😀", "😀") in respell("いい天気😀")


@needs_dictionary
@full
@pytest.mark.parametrize("text", ["水を買う、" * MAX_READ_CHARS, "あ" * (3 * MAX_READ_CHARS)])
def test_a_text_without_an_end_is_read_in_parts(text):
    pieces = respell(text)
    assert "".join(piece for piece, _ in pieces) == text
    assert "".join(spelling for _, spelling in pieces).count("ミズ") in (0, MAX_READ_CHARS)


@needs_dictionary
def test_a_word_before_a_particle_or_a_title_stays_a_word():
    words = [piece for piece, _ in respell("神田さんの本も社会的だ")]
    assert words == ["神田", "さん", "の", "本", "も", "社会的", "だ"]


@needs_dictionary
def test_nothing_is_printed(capfd):
    dictionary.cache_clear()
    respell("！？今日は良い天気。ーー")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("missing", [None, "the library it continues"])
def test_without_the_dictionary_it_says_how_to_get_it(monkeypatch, missing):
    dictionary.cache_clear()
    other = missing and type(sys)("pyopenjtalk")
    monkeypatch.setitem(sys.modules, "pyopenjtalk", other)
    with pytest.raises(SpeechError, match=r'pip install "lipsync-lang\[japanese\]"'):
        respell("日本")
    dictionary.cache_clear()


def test_what_cannot_be_traced_back_to_the_letters_is_one_piece(monkeypatch):
    class Lost:
        """A dictionary that reads a sentence without the letters of each word."""

        def g2p_mapping(self, *_, **__):
            raise ValueError

        def g2p(self, *_, **__):
            return "ナ’ニカヲ"

    dictionary.cache_clear()
    monkeypatch.setitem(sys.modules, "pyopenjtalk", Lost())
    assert respell("何かを。") == [("何かを", "ナ̥ニカオ"), ("。", "。")]
    dictionary.cache_clear()
