"""Interjections and stutters of game scripts, in 13 languages, read by the packs' own engines."""

import re

import pytest
from lanes import full

from lipsync_lang import transcribe

pytestmark = full

LATIN = {
    "Mmm": "bmp+", "Mmmmh": "bmp+", "Hm": "H?bmp", "Hmmm": "H?bmp+", "Mhm": "bmp H?bmp",
    "Mm-hm": "bmp+ H?bmp", "Hmph": "H?bmp f", "Mpf": "bmp f", "Sh": "S", "Shh": "S+",
    "Shhhhh": "S+",
    "Pshh": "bmp S+", "Psst": "bmp s+d", "Pst": "bmp s d", "Pssst": "bmp s+d", "Pfft": "bmp f+d",
    "Pff": "bmp f+", "Pffff": "bmp f+", "Brr": "bmp R+", "Brrrr": "bmp R+", "Grr": "kg R+",
    "Grrrr": "kg R+", "Rrrr": "R+", "Zzz": "s+", "Zzzzzz": "s+", "Bzzz": "bmp s+", "Sssss": "s+",
    "Tsk": "d s kg", "Tsss": "d s+", "Ugh": "V(kg|h)", "Uggghh": "V(kg|h)+", "Argh": "V+R?kg",
    "Aaaargh": "V+R?kg", "Eek": "V+kg", "Eeeek": "V+kg", "Haha": "H?V H?V", "Hahahaha": "(H?V)+",
    "Hihihi": "(H?V)+", "Ahem": "V H?V bmp", "HMMM": "H?bmp+",
}  # fmt: skip
"""Sounds of interjections: common phonemes, with H, S, R and V for groups of them."""

CYRILLIC = {
    "Мм": "bmp+", "Мммм": "bmp+", "МММ": "bmp+", "Хм": "H bmp", "Хммм": "H bmp+",
    "Гм": "H bmp",
    "Гммм": "H bmp+", "Кхм": "kg H bmp", "Кхм-кхм": "kg H bmp kg H bmp",
    "Тсс": "d s+", "Тссс": "d s+",
    "Тс": "d s", "Тшш": "d S+", "Шш": "S+", "Шшшш": "S+", "Пст": "bmp s d",
    "Псст": "bmp s+d",
    "Пф": "bmp f", "Пфф": "bmp f+", "Пффф": "bmp f+", "Пфт": "bmp f d",
    "Брр": "bmp R+",
    "Бррр": "bmp R+", "Грр": "H R+", "Гррр": "H R+", "Ррр": "R+",
    "Хрр": "H R+", "Хррр": "H R+",
    "Ззз": "s+", "Зззз": "s+", "Бзз": "bmp s+", "Ссс": "s+", "Хаха": "(H V)+",
    "ХАХАХА": "(H V)+",
    "Ха-ха-ха": "(H V)+", "Хехе": "(H V)+", "Хихихи": "(H V)+",
    "Хохо": "(H V)+", "Ааааа": "V+",
    "Оооо": "V+",
}  # fmt: skip

LIKE = {"H": "(h|kg|x)", "S": "(sh|xi|s)", "R": "(r|d|l|kg|rr|er)",
        "V": "(aa|ae|ah|ao|ax|eh|er|ey|ih|iy|oa|oc|oe|ow|oy|uh|ux|w|wx|yu|y|aw|ay)"}  # fmt: skip

OWN = {
    "japanese": {
        "えっと": "eh d d V", "うーん": "wx+ng", "あのー": "aa n V", "ふふふ": "((f|bw) wx)+",
        "ははは": "h aa h aa h aa",
        "へへへ": "(h eh)+", "シーッ": "xi iy h", "ちぇっ": "xi eh h", "うわっ": "wx w aa h",
        "きゃあ": "kg aa+",
        "んー": "ng", "むむむ": "(bmp wx)+", "ぷっ": "bmp wx h", "ぐぐぐ": "(kg wx)+",
        "ううう": "wx+",
        "ああああ": "aa+", "えええ": "eh+", "ほほう": "h V h V+", "ひいっ": "h iy+h",
        "ぎゃあ": "kg aa+",
    },
    "korean": {
        "음": "V bmp", "흠": "h V bmp", "쉿": "s w V d", "응": "V ng", "하하하": "(h V)+",
        "헤헤": "(h V)+",
        "흥": "h V ng", "쳇": "(ch|xi|d xi)(h)?V d", "으악": "V V kg",
        "푸하하": "bmp h?V h V h V",
    },
    "mandarin": {
        "嗯": "n", "呃": "V", "哈哈哈哈": "(h V)+", "呵呵": "(h V)+", "嘿嘿": "(h V)+",
        "嘘": "xi V",
        "哼": "h V ng", "唉": "V", "啊啊啊": "V+", "噗": "bmp V", "哦哦": "V+", "咦": "V",
        "嗷": "V",
        "呸": "bmp V", "嘻嘻": "(xi V)+", "嘿": "h V", "喂": "w?V", "呜呜": "V+", "哇": "w?V",
        "Mmm": "bmp+",
    },
}  # fmt: skip
OWN["mandarin traditional"] = {"噓": "xi V", "喔": "V", "哈哈哈": "(h V)+", "嗚嗚": "V+", "欸": "V"}

STUTTERS = {
    "english": (
        "w-what th-that's b-but s-sorry p-please d-don't n-no I-I'm m-me c-can't "
        "ch-children kn-know st-stop thr-three y-you h-how qu-quiet sh-she wh-where "
        "g-go"
    ),
    "czech": (
        "c-co n-ne j-já m-možná p-prosím d-dobře t-to k-kde s-sakra ch-chci z-zase "
        "b-byl v-víš ř-řekni š-škoda č-čekej h-holka st-stůj pr-proč o-ona"
    ),
    "danish": (
        "h-hvad n-nej j-jeg d-du m-men k-kan s-skal v-vi t-tak f-for b-bare g-godt "
        "l-lige r-rigtig p-på sk-skynd st-stop o-og a-alt u-undskyld"
    ),
    "french": (
        "q-quoi n-non j-je m-mais p-pas t-tu c-c'est v-vous d-dans s-si b-bon f-faut "
        "l-le r-rien ch-chérie g-grand pl-plus tr-très a-alors o-oui"
    ),
    "italian": (
        "c-cosa n-no s-sì m-ma p-per t-tu d-dove v-vai q-quando ch-chi b-bene f-fai "
        "g-grazie l-la r-ragazzi sc-scusa st-sto pr-prego a-aiuto o-ora"
    ),
    "spanish": (
        "q-qué n-no s-sí m-mi p-pero t-tú d-dónde v-voy c-cómo b-bueno f-fue "
        "g-gracias l-la r-rojo ll-llama ch-chico y-yo tr-tres a-ayuda e-espera"
    ),
    "malay": (
        "a-apa s-saya t-tidak m-mana b-boleh d-dia k-kamu j-jangan p-pergi n-nanti "
        "l-lari r-rumah g-gila h-hari c-cepat w-wah i-ibu ng-ngeri ny-nyamuk u-untuk"
    ),
    "russian": (
        "ч-что н-нет к-как я-я п-пожалуйста д-да "
        "м-мне б-блин т-ты з-знаю с-стой в-вы г-где "
        "ж-жди х-хватит ш-шутишь л-ладно р-разве "
        "о-она у-уйди"
    ),
    "ukrainian": (
        "щ-що н-ні я-як п-прошу д-де м-мені б-будь т-ти "
        "з-знаю с-стій в-ви г-геть ж-жди х-хто ч-чому "
        "л-ладно р-разом о-она у-уже к-коли"
    ),
    "korean": (
        "ㅁ-뭐 ㄱ-그게 ㄴ-나 ㅈ-저기 ㅇ-아니 ㅅ-사람 ㅂ-바보 ㄷ-다시 ㅎ-하지 ㄹ-라면 "
        "그-그게 저-저기 나-나는 자-잠깐 뭐-뭐야 아-아니 너-너는 바-바보 사-사람 "
        "다-다시"
    ),
    "japanese": (
        "あ、あの そ、それ ち、違う え、ええ わ、私 き、君 ま、待って な、何 ど、どう "
        "い、いや は、はい た、助けて ちょ、ちょっと お、お前 こ、これ や、やめて "
        "う、嘘 す、すみません ご、ごめん で、でも"
    ),
    "mandarin": (
        "我、我不 你、你是 什、什么 不、不要 他、他在 怎、怎么 没、没有 对、对不起 "
        "等、等等 好、好吧 是、是的 那、那个 这、这是 为、为什么 别、别走 快、快跑 "
        "真、真的 可、可是 谢、谢谢 救、救命"
    ),
    "mandarin traditional": (
        "我、我不 你、你是 什、什麼 不、不要 沒、沒有 對、對不起 這、這是 為、為什麼 "
        "別、別走 謝、謝謝"
    ),
}  # fmt: skip


def patterns(language):
    """The interjections of a language, each with its sounds."""
    name = language.partition(" ")[0]
    latin = {} if name in ("russian", "ukrainian", "mandarin", "japanese") else LATIN
    cyrillic = CYRILLIC if name in ("russian", "ukrainian") else {}
    return {**latin, **cyrillic, **OWN.get(language, {})}


def expression(pattern):
    """An expression over common phonemes that are each followed by a space."""
    parts = re.findall(r"[a-z]+|[HSRV]|[()|+?]", pattern)
    return "".join(
        f"(?:{part} )" if part.isalpha() and part.islower()
        else "(?:" + "|".join(f"{one} " for one in LIKE[part].strip("()").split("|")) + ")"
        if part in LIKE else part for part in parts
    )  # fmt: skip


@pytest.mark.parametrize("language", STUTTERS)
def test_interjections_are_sounds(language):
    wanted = patterns(language)
    read = transcribe([f"{one}!" for one in wanted], language.partition(" ")[0])
    wrong = {
        one: " ".join(found.phonemes)
        for (one, pattern), found in zip(wanted.items(), read, strict=True)
        if not re.fullmatch(
            expression(pattern), "".join(f"{p} " for p in found.phonemes if p != "_")
        )
    }
    assert not wrong


@pytest.mark.parametrize("language", STUTTERS)
def test_stutters_repeat_the_sound_of_the_word(language):
    name = language.partition(" ")[0]
    texts = STUTTERS[language].split()
    plain = [re.split("[-、]", text)[-1] for text in texts]
    said, words = transcribe(texts, name), transcribe(plain, name)
    wrong = {}
    for text, stutter, word in zip(texts, said, words, strict=True):
        whole = tuple(label for one in stutter.words for label in one.labels)
        start, rest = whole[: -len(word.labels)], whole[-len(word.labels) :]
        # of a cluster the first sounds, then the vowel
        begins = start[:-1] == word.labels[: len(start) - 1]
        if not (start and rest == word.labels and begins and set(start) <= set(word.labels)):
            wrong[text] = (whole, word.labels)
    assert not wrong


def test_lists_are_long_enough():
    assert all(len(patterns(name)) >= 40 for name in ("english", "russian", "korean", "french"))
    assert all(len(words.split()) >= 20 for name, words in STUTTERS.items() if " " not in name)
