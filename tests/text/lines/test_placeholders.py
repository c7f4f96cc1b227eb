"""Placeholders of games in twenty languages: none is spoken, and no word beside one is lost."""

import re

import pytest

from lipsync_lang.text.lines.cleaning import Cleaning
from lipsync_lang.text.lines.markup import FORMS as FORMS_OF_MARKUP
from lipsync_lang.text.lines.markup import spoken
from lipsync_lang.text.phonology.espeak.process import blank

SPACED = {
    "english": "I will give @ to you",
    "german": "Ich gebe @ dem Wirt",
    "french": "Je donne @ à ce vieux marchand",
    "spanish": "Voy a darle @ al rey",
    "polish": "Dam @ temu kupcowi",
    "czech": "Dám @ tomu kupci",
    "russian": "Я отдам @ этому купцу",
    "ukrainian": "Я віддам @ цьому купцеві",
    "greek": "Θα δώσω @ στον έμπορο",
    "turkish": "Sana @ vereceğim",
    "hungarian": "Adok @ annak az embernek",
    "finnish": "Annan @ kauppiaalle",
    "arabic": "سأعطي @ للتاجر",
    "hebrew": "אתן את @ לסוחר",
    "hindi": "मैं @ व्यापारी को दूँगा",
    "vietnamese": "Tôi sẽ đưa @ cho người bán",
    "korean": "상인에게 @ 주겠다",
}
GLUED = {
    "mandarin": "你有@个金币了",
    "cantonese": "你有@個金幣喇",
    "japanese": "村で@を手に入れた",
    "korean": "너는 @에게 간다",
    "thai": "คุณมี@เหรียญ",
    "german": "Da sind @en Schaden",
    "turkish": "Şimdi @den geldim",
    "finnish": "Menen @ssa kotiin",
    "russian": "Это @ами сделано",
}
FORMS = (
    "%s %d %1$s %2$d %03d %.2f %@ %1$@ %ld %lld %+d %(name)s %(count)d %PLAYER% %{name} %<name>s"
    " {name} {0} {0:N2} {name!t} {} {{name}} {{name|upper}} ${name} #{name} {$name} @me@ #name#"
    " [name] [name!t] [player.name] <name> $t(common.name) $[name] $NAME$ $1$ %%name%% %1% %1!s!"
    " <0> </0> <1/> <@user> &player; ~r~ ~INPUT_JUMP~ __NAME__ __name__"
    " \\{ \\} \\C[4] \\N[1] \\V[\\V[2]]"
)
ENDED_BY_A_SPACE = (
    "%i %u %c %x %*d %item %1 %L1 %1/%2 $name $player.name $player->name \\$name @name @1 %zu %n %m"
    " _%s_ «%s» (%s) %%s :name: ::name:: £gold£ §a §6§l &a &6 &a@1 ^1 ^xF00 \\p \\cff \\ca"
    " |cFF0000%s|r |cffff0000%s|r|n"
)
UNSPACED = ("mandarin", "cantonese", "japanese", "thai")
ORDINARY = (
    "It costs $5, or $1 each|R&D, Q&A and AT&T; then|salt &pepper|100 % sure, 5 % of them|50% off"
    "|a:b:c at 10:30:15|§ 5 and §6 Abs. 2|#1 in C#|We meet @ home @ 5|5 @ 3|it is 2*3|24/7 km/h"
    "|%50 indirim, %1,5 arttı, %1'i|US$1 or $1,000|a ratio of 3:2:1|9 < 10 > 3|Ann:Bob:Cy"
    "|20%-os|1. Go|5% discount"
)


def letters(text):
    return "".join(filter(str.isalpha, text))


@pytest.mark.parametrize("language", SPACED)
def test_a_placeholder_between_words_is_not_spoken(language):
    for form in f"{FORMS} {ENDED_BY_A_SPACE}".split():
        found = spoken(SPACED[language].replace("@", form))
        assert letters(found.text) == letters(SPACED[language]), form
        assert not set("%${}@_&^|~§\\0123456789") & set(found.text), form


@pytest.mark.parametrize("language", GLUED)
def test_a_placeholder_glued_to_letters_leaves_them(language):
    before, after = GLUED[language].split("@")
    for form in FORMS.split():
        found = spoken(GLUED[language].replace("@", form))
        assert letters(found.text) == letters(before + after), form
        assert letters(before[-2:]) + letters(after[:2]) not in found.text.split(), form


@pytest.mark.parametrize("language", UNSPACED)
def test_a_placeholder_ends_where_another_script_begins(language):
    for form in f"{ENDED_BY_A_SPACE} %name".split():
        found = spoken(GLUED[language].replace("@", form))
        assert letters(found.text) == letters(GLUED[language]), form


@pytest.mark.parametrize("text", ORDINARY.split("|"))
def test_ordinary_signs_are_no_placeholders(text):
    assert spoken(text).text == text


def test_examples_of_markup_are_found_by_their_patterns():
    for examples, pattern in (form for kind in FORMS_OF_MARKUP.values() for form in kind.items()):
        one_by_one = all(re.search(pattern, example) for example in examples.split(" "))
        assert one_by_one or re.search(pattern, examples), examples


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("%1$d個の石", "個の石"),
        ("_%s_ в её руках", "в её руках"),
        ("%sen Schaden", "en Schaden"),
        ("%s个%d金", "个 金"),
        ("给{0}的{1}", "给 的"),
        ("%d/%d HP", "HP"),
        ("Take {name}'s sword", "Take sword"),
        ("%ds left", "left"),
        ("%dkm weit", "km weit"),
        ("%dfache Wirkung, %5dkm", "fache Wirkung, km"),
        ("%-10spunktów", "punktów"),
        ("It does %damage now", "It does now"),
        ("pre[player]s B-but", "pre B-but"),
        # a percentage is none
        ("100%sicher", "100%sicher"),
        ("100 %sicher", "100 %sicher"),
        ("%50 indirim, %50'si, %50den", "%50 indirim, %50'si, %50den"),
        ("20%de rabais", "20%de rabais"),
        ("5% discount", "5% discount"),
        ("I pay $5", "I pay $5"),
        ("100%% sure, 50%%d", "100% sure, 50%d"),
        ("At 10:30: yes, £5, §5 and § 110", "At 10:30: yes, £5, §5 and § 110"),
        ("§aGreen§r and §4red§! <%= x %>", "Green and red"),
        # beside another of its kind
        ("%1 of %2, %2 kaldı", "of, kaldı"),
        ("%2 kaldı", "%2 kaldı"),
        ("§aYes §6 no", "Yes no"),
        ("&bgold&r now, &pepper", "gold now, &pepper"),
        ("some &bgold", "some &bgold"),
        ("Ann^7 is ^1red", "Ann is red"),
        ("It is |cFF0000red|r|nnow", "It is red now"),
        ("one|red", "one red"),
        ("\\{Hello\\} \\$name, you", "Hello, you"),
        ("你有@1.个金币了", "你有.个金币了"),
        # choices
        ("{n, plural, one {# coin} other {# coins}}", "coins"),
        ("{sex, select, male {他} female {她} other {他们}}来了", "他们来了"),
        ("{n:plural:coin|{} coins} found", "coins found"),
        ("{0:choose(m|f):he|she} left", "he left"),
        ("{n} {n}|plural(one=cat,other=cats)", "cats"),
        ("{who}|gender(le,la) chat", "le chat"),
        ('{NUM} coin{P "" s} in {TOWN}', "coins in"),
        ("{P 0 wagon wagons} gone", "wagons gone"),
        ("{{#if met}}Hello{{/if}} again", "Hello again"),
        # rich text
        ('<RichText.Bold>Go</> <img id="x"/>now', "Go now"),
        ("<color=#fff>G</color>o <sprite=3>on", "Go on"),
    ],
)
def test_what_is_left_of_a_line_with_placeholders(written, said):
    assert spoken(written).text == said


def test_values_of_placeholders_and_branches_are_spoken():
    known = Cleaning({"name": "Ada", "n": "1"})
    assert spoken("{name}'s {n}|plural(one=cat,other=cats)", known).text == "Ada's cat"
    assert spoken("{{name}}さん %(name)sさん", known).text == "Adaさん Adaさん"


@pytest.mark.parametrize(
    ("text", "sent"),
    [
        ("Hi, !", "Hi,  "),
        ("!?", "  "),
        ("...! Hi", ",    Hi"),
        ("Wait...!", "Wait!   "),
        ("Wait…!? No... no", "Wait!?  No,   no"),
        ("नमस्ते। ।", "नमस्ते।  "),
        ("Well: : yes", "Well:   yes"),
        ("Really?! Wow!! No", "Really?! Wow!! No"),
        ("said:never, EU:n", "said never, EU:n"),
        ("Go!Go!!Run?!No", "Go！Go！！Run？！No"),
        ("No: yes! (What?) Salut !", "No: yes! (What?) Salut !"),
    ],
)
def test_a_voice_gets_no_mark_alone_to_name(text, sent):
    assert blank(text) == sent
