"""Right texts of voices that the model hears badly pass, and wrong ones are doubted."""

import pytest
from lanes import swept

from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.sound.speech.hearing.alignment import align_many
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")

LINES = {
    "russian": (
        "Корабль капитана стоит в старом порту с прошлой осени.",
        "Никто из нас не хотел открывать железную дверь.",
        "Завтра утром мы вернёмся домой через лес.",
    ),
    "danish": (
        "Skibet ligger stadig nede i havnen ved den gamle bro.",
        "Ingen af os turde åbne den tunge dør.",
        "I morgen tidlig går vi hjem gennem skoven.",
    ),
    "spanish": (
        "El barco del capitán lleva meses en el puerto viejo.",
        "Nadie quería abrir la puerta de hierro.",
        "Mañana volveremos a casa por el bosque.",
    ),
    "french": (
        "Le bateau du capitaine est au vieux port depuis l'automne.",
        "Personne n'osait ouvrir la lourde porte en fer.",
        "Demain matin nous rentrerons par la forêt.",
    ),
    "italian": (
        "La nave del capitano è nel vecchio porto da mesi.",
        "Nessuno voleva aprire la porta di ferro.",
        "Domani mattina torneremo a casa dal bosco.",
    ),
    "ukrainian": (
        "Корабель капітана стоїть у старому порту з осені.",
        "Ніхто не хотів відчиняти залізні двері.",
        "Завтра вранці ми повернемося додому через ліс.",
    ),
    "japanese": (
        "船長の船は秋から古い港にあります。",
        "誰も鉄のドアを開けたくなかった。",
        "明日の朝、森を通って家に帰ります。",
    ),
    "korean": (
        "선장의 배는 가을부터 낡은 항구에 있습니다.",
        "아무도 철문을 열고 싶어 하지 않았다.",
        "내일 아침 숲을 지나 집으로 돌아갑니다.",
    ),
}


@pytest.mark.parametrize("language", swept(LINES, quick=["russian", "danish"]))
def test_the_text_of_a_voice_is_told_from_other_texts(language):
    speaker, texts = Speaker.of(language), LINES[language]
    sounds = [speaker.speak(text).audio for text in texts]
    if None in sounds:
        pytest.skip(f"no voice speaks {language}")
    pairs = [(sound, text) for sound in sounds for text in texts]
    found = align_many(speaker, pairs)
    sure = [getattr(one, "confidence", 0.0) >= DOUBTFUL for one in found]
    assert sure == [text == own for own in texts for text in texts]


def test_marks_of_danish_vowels_are_heard_as_no_stop():
    # some words were too short for these stops, and were left out
    speaker = Speaker.of("danish")
    text = "Jeg kan ikke indrømme, at det hele røg ind ad det ene øre og ud af det andet."
    spoken = speaker.speak(text).audio
    exchanged = text.replace("hele røg", "røg hele")
    found, moved = align_many(speaker, [(spoken, text), (spoken, exchanged)])
    assert found.left_out == ()
    assert found.confidence >= DOUBTFUL > moved.confidence


def test_a_word_before_a_pause_is_no_other_sound():
    speaker = Speaker.of("english")
    text = "Hey... Umm..."
    spoken = speaker.speak(text).audio
    found, wrong = align_many(speaker, [(spoken, text), (spoken, "I'd love to!")])
    assert found.confidence >= DOUBTFUL > getattr(wrong, "confidence", 0.0)
    hey, umm = (found.times[word.first] for word in found.words)
    assert hey < 0.1
    assert umm > 0.4
