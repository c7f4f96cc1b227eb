"""Rules of numbers that are like others: the ends of their words, and the signs behind."""

import pytest
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.packs.models.text_models import LanguageText, RulesLike
from lipsync_lang.text.phonology.g2p.number_words import number_words


def tables(rules):
    return LanguageText.model_validate({"number_rules": rules}).number_tables


def test_the_longest_ending_wins_and_brackets_stay():
    ordinal = {"1": "primo", "2": "tertio", "20": "vigesimo[ >]", "30": "trenta >", "100": "cento>"}
    other = {"like": "ordinal", "endings": {"o": "a", "io": "ja", "trenta": "trente", "x": "y"}}
    assert tables({"feminine": other, "ordinal": ordinal})["feminine"] == {
        "1": "prima", "2": "tertja", "20": "vigesima[ >]", "30": "trente >", "100": "centa>",
    }  # fmt: skip


def test_a_whole_word_may_change():
    other = {"like": "metre", "endings": {"metre": "foot", "metres": "feet"}}
    made = tables({"metre": {"1": "metre", "2": "metres"}, "foot": other})
    assert [number_words(made["foot"], one) for one in "12"] == ["foot", "feet"]


@pytest.mark.parametrize("name", LANGUAGES)
def test_tables_of_packs_are_full(name):
    text = LIBRARY.language(name).model.text
    stated = text.number_rules if text else {}
    like = {one for one, rules in stated.items() if isinstance(rules, RulesLike)}
    assert all(text.number_tables[one] for one in like)
    assert stated.keys() == (text.number_tables.keys() if text else set())
