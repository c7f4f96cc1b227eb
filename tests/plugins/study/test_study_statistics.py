"""Statistics of studies, compared with tables, textbooks, scipy and brute force."""

import random
from itertools import product
from math import log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full
from scipy import stats
from study_answers import crowd, model, placed, study_of

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.plugins.study.answer_sorting import sort_answers
from lipsync_lang.plugins.study.bradley_terry import fitted_strengths, ranked, ranking
from lipsync_lang.plugins.study.comparisons import (
    ALL_CHARACTERS,
    Choice,
    agreement,
    chi_square,
    chi_square_tail,
    clustering,
    compared,
    even_odds,
    mean_strength,
    sign_flips,
    t_quantile,
    wilson,
)
from lipsync_lang.plugins.study.power import (
    PowerQuestion,
    choices_needed,
    effective_choices,
    exact_power,
    plan_study,
)

# Distributions


@given(st.floats(0, 400), st.integers(1, 30))
def test_the_tail_of_chi_square_is_scipys(statistic, freedom):
    wanted = stats.chi2.sf(statistic, freedom)
    assert chi_square_tail(statistic, freedom) == pytest.approx(wanted, rel=1e-9, abs=1e-300)


@pytest.mark.parametrize(
    ("freedom", "critical"), [(1, 3.841), (2, 5.991), (3, 7.815), (10, 18.307)]
)
def test_the_tail_of_chi_square_is_that_of_the_tables(freedom, critical):
    assert chi_square_tail(critical, freedom) == pytest.approx(0.05, abs=2e-5)


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 9, 30, 199, 200, 201, 1000, 50_000])
def test_the_quantile_of_t_is_scipys(freedom):
    assert t_quantile(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=1e-6)


def test_wilsons_interval_is_newcombes():
    # Newcombe 1998, Statistics in Medicine 17:857, table I: method 3
    wanted = {(81, 263): (0.2553, 0.3662), (15, 148): (0.0624, 0.1605), (0, 20): (0.0, 0.1611)}
    wanted[1, 29] = (0.0061, 0.1718)
    for (successes, trials), (low, high) in wanted.items():
        assert wilson(successes, trials) == pytest.approx((low, high), abs=5e-5)


@given(st.integers(1, 300), st.data())
def test_the_binomial_test_is_scipys(trials, data):
    successes = data.draw(st.integers(0, trials))
    wanted = stats.binomtest(successes, trials).pvalue
    assert even_odds(successes, trials) == pytest.approx(wanted, rel=1e-9)


@given(st.lists(st.integers(-6, 6), min_size=1, max_size=9))
def test_the_sign_flip_test_counts_all_signs(differences):
    observed = abs(sum(differences))
    totals = [
        abs(sum(sign * one for sign, one in zip(signs, differences, strict=True)))
        for signs in product((-1, 1), repeat=len(differences))
    ]
    wanted = sum(total >= observed for total in totals) / len(totals)
    assert sign_flips(differences) == pytest.approx(wanted)


@given(st.integers(1, 200), st.data())
def test_raters_of_one_choice_each_are_a_binomial_test(trials, data):
    successes = data.draw(st.integers(0, trials))
    flips = sign_flips([1] * successes + [-1] * (trials - successes))
    assert flips == pytest.approx(even_odds(successes, trials), rel=1e-9)


# Comparisons


def choices_of(wins, methods=("ours", "theirs"), raters=10, strength=3):
    """Return a number of choices for each of two methods, by raters in turn."""
    pairs = [(0, 1)] * wins[0] + [(1, 0)] * wins[1]
    return [
        Choice(
            f"r{n % raters}", f"p{n // raters}", f"l{n // raters}", "anna", "accuracy",
            methods[a], methods[b], strength,
        )
        for n, (a, b) in enumerate(pairs)
    ]  # fmt: skip


def test_two_counts_have_the_chi_square_of_their_difference():
    assert chi_square([134, 66]) == pytest.approx(200 * 0.34**2) == pytest.approx(23.12)
    assert chi_square([10, 20, 30]) == pytest.approx(stats.chisquare([10, 20, 30]).statistic)


def test_a_comparison_counts_what_is_there():
    (one,) = compared(choices_of((134, 66)), ("ours", "theirs"))
    assert (one.choices, one.for_first, one.raters, one.lines) == (200, 134, 10, 20)
    assert one.difference == pytest.approx(0.34)
    assert one.p_binomial == pytest.approx(stats.binomtest(134, 200).pvalue)
    assert one.p_chi_square == pytest.approx(stats.chi2.sf(23.12, 1))
    assert (one.strength_of_first.choices, one.strength_of_second.choices) == (134, 66)


def test_all_characters_stand_below_each_of_several():
    two = choices_of((9, 4)) + [one._replace(character="ben") for one in choices_of((2, 5))]
    found = compared(two, ("ours", "theirs"))
    assert [(one.character, one.for_first, one.choices) for one in found] == [
        ("anna", 9, 13),
        ("ben", 2, 7),
        (ALL_CHARACTERS, 11, 20),
    ]


def test_agreement_is_krippendorffs():
    # Krippendorff 2011, Computing Krippendorff's Alpha-Reliability, A: binary data, 2 observers
    meg, owen = "0100000010", "1110010000"
    two = [
        Choice(name, f"p{n}", f"p{n}", "anna", "accuracy", value, "-", 3)
        for name, row in (("meg", meg), ("owen", owen))
        for n, value in enumerate(row)
    ]
    found = agreement(two)
    assert found.alpha == pytest.approx(0.095, abs=5e-4)
    assert (found.pairs, found.percent) == (10, pytest.approx(60))
    assert agreement(two[:10]) is None, "one rater agrees with nobody"


def test_agreement_leaves_out_pairs_of_one_rater_and_knows_nothing_of_unanimity():
    same = choices_of((20, 0))
    assert agreement(same) == (2, 100.0, None)
    alone = Choice("r1", "p9", "l9", "anna", "accuracy", "theirs", "ours", 3)
    assert agreement([*same, alone]) == (2, 100.0, None)


def test_the_design_effect_of_copied_choices_is_their_number():
    single = [Choice(f"r{n}", "p1", "l1", "anna", "q", *ab, 3) for n, ab in enumerate(SIDES * 20)]
    copied = [one._replace(pair=f"p{n}") for one in single for n in range(5)]
    once, five = clustering(single, "ours"), clustering(copied, "ours")
    assert five.design_effect == pytest.approx(5 * once.design_effect)
    assert five.correlation == pytest.approx(1, abs=0.05)
    assert five.interval == pytest.approx(once.interval, abs=0.01), "copies tell nothing new"


SIDES = [("ours", "theirs"), ("theirs", "ours"), ("ours", "theirs")]


def test_one_rater_has_no_interval_and_equal_raters_count_once():
    assert clustering(choices_of((5, 3), raters=1), "ours") == (None, None, None)
    assert mean_strength(choices_of((5, 3), raters=1)) == (8, 3.0, None)
    assert mean_strength([]) is None
    same = clustering(choices_of((40, 0), raters=4), "ours")
    assert same.interval == wilson(4, 4, t_quantile(3))


def test_the_mean_strength_of_one_choice_each_is_students():
    values = [1, 2, 2, 3, 5, 4, 4]
    given_ = [
        one._replace(strength=value)
        for one, value in zip(choices_of((7, 0), raters=7), values, strict=True)
    ]
    found = mean_strength(given_)
    wanted = stats.t.interval(0.95, 6, np.mean(values), stats.sem(values))
    assert found.mean == pytest.approx(np.mean(values))
    assert found.interval == pytest.approx(wanted)


# Bradley-Terry

LEAGUE = {
    "Milwaukee": (0, 7, 9, 7, 7, 9, 11),
    "Detroit": (6, 0, 7, 5, 11, 9, 9),
    "Toronto": (4, 6, 0, 7, 7, 8, 12),
    "New York": (6, 8, 6, 0, 6, 7, 10),
    "Boston": (6, 2, 6, 7, 0, 7, 12),
    "Cleveland": (4, 4, 5, 6, 6, 0, 6),
    "Baltimore": (2, 4, 1, 3, 1, 7, 0),
}
"""American League 1987, wins of the row over the column (Agresti, Categorical Data Analysis)."""


def games(table):
    """Return the choices of a table of wins."""
    names = list(table)
    return [
        Choice(f"r{n}", f"{winner}{loser}", "l1", "anna", "q", winner, loser, 3)
        for winner, row in table.items()
        for loser, count in zip(names, row, strict=True)
        for n in range(count)
    ]


def test_strengths_are_agrestis():
    wanted = (1.58, 1.44, 1.29, 1.25, 1.11, 0.68, 0)
    found = fitted_strengths(np.array(list(LEAGUE.values()), float))
    assert found - found[-1] == pytest.approx(wanted, abs=0.006)


def test_a_ranking_is_told_strongest_first():
    found = ranking(games(LEAGUE), list(LEAGUE))
    assert [one.method for one in found.methods] == list(LEAGUE)
    assert found.freedom == 6
    assert sum(one.strength for one in found.methods) == pytest.approx(0)
    assert np.mean([one.beats_others for one in found.methods]) == pytest.approx(0.5)
    for one in found.methods:
        assert one.interval.low < one.strength < one.interval.high


@given(st.lists(st.floats(-2, 2), min_size=2, max_size=6))
def test_known_strengths_are_recovered(strengths):
    known = np.array(strengths) - np.mean(strengths)
    games_each = 1e5
    wins = games_each / (1 + np.exp(known[None, :] - known[:, None]))
    np.fill_diagonal(wins, 0)
    assert fitted_strengths(wins) == pytest.approx(known, abs=1e-6)


@given(st.integers(1, 500), st.integers(1, 500))
def test_two_methods_have_the_odds_of_their_share(wins, losses):
    found = fitted_strengths(np.array([[0, wins], [losses, 0]], float))
    assert found[0] - found[1] == pytest.approx(log(wins / losses), abs=1e-7)


@given(st.integers(1, 60), st.integers(1, 60))
def test_the_likelihood_ratio_of_two_methods_is_that_of_the_binomial(wins, losses):
    found = ranking(choices_of((wins, losses)), ("ours", "theirs"))
    number = wins + losses
    wanted = 2 * (wins * log(2 * wins / number) + losses * log(2 * losses / number))
    assert found.likelihood_ratio == pytest.approx(wanted, abs=1e-6)


@given(st.integers(1, 60), st.integers(1, 60))
def test_flips_of_two_methods_are_the_exact_test(wins, losses):
    choices = choices_of((wins, losses), raters=9)
    (exact,) = compared(choices, ("ours", "theirs"))
    found = ranking(choices, ("ours", "theirs"))
    assert found.p_raters == pytest.approx(exact.p_raters, abs=0.015)


def test_raters_who_disagree_on_three_methods_give_no_ranking_however_much_they_say():
    cycle = [("a", "b"), ("b", "c"), ("a", "c")]
    choices = [
        Choice(f"r{n}", f"p{m}", "l1", "anna", "q", *(ends if n % 2 else ends[::-1]), 3)
        for n in range(9)
        for m in range(60)
        for ends in cycle
    ]
    found = ranking(choices, "abc")
    assert found.p_likelihood_ratio < 0.005
    assert found.p_raters == 1, "five against four raters are as near to none as nine can be"


def test_methods_that_no_choice_connects_have_no_strengths():
    apart = choices_of((3, 2), ("a", "b")) + choices_of((3, 2), ("c", "d"))
    found = ranking(apart, ("a", "b", "c", "d"))
    assert found.problem == "no choice connects these groups of methods: a, b | c, d"
    assert found.methods == ()


def test_a_method_that_never_loses_has_no_limit():
    found = ranking(choices_of((3, 2), ("a", "b")) + choices_of((4, 0), ("c", "a")), "abc")
    assert found.problem == "no choice prefers a, b to c, so the strengths have no limit"


def test_two_methods_need_no_ranking_and_three_have_one_for_each_character():
    assert ranked(choices_of((3, 2)), ("ours", "theirs")) == []
    three = [
        one._replace(character=who, pair=f"{who}{n}")
        for who in ("anna", "ben")
        for ends in (("a", "b"), ("b", "c"), ("c", "a"))
        for n, one in enumerate(choices_of((3, 2), ends))
    ]
    assert [one.character for one in ranked(three, "abc")] == ["anna", "ben", ALL_CHARACTERS]


def test_a_rater_who_repeats_choices_narrows_no_interval():
    once = [one._replace(rater=f"r{n}") for n, one in enumerate(games(LEAGUE))]
    single, repeated = ranking(once, list(LEAGUE)), ranking(once * 5, list(LEAGUE))
    for one, five in zip(single.methods, repeated.methods, strict=True):
        assert five.strength == pytest.approx(one.strength)
        width, wide = (m.interval.high - m.interval.low for m in (one, five))
        assert wide == pytest.approx(width, rel=0.15)
        assert wide > 0.85 * width, "independent choices would give less than half"


# Promises over many studies


def comparison_of(tmp_path, study, submissions):
    folder = placed(tmp_path, study, submissions)
    found = sort_answers([folder / "answers.jsonl"], model(study))
    return compared(found.choices, study["methods"])


def p_values(spread, studies, raters=12, pairs=10):
    """Return p of each test over studies of raters without a common preference."""
    chance = random.Random(5)  # noqa: S311 no secret
    found = []
    for _ in range(studies):
        choices = []
        for rater in range(raters):
            size = 1 / spread - 1 if spread else 0
            own = chance.betavariate(size / 2, size / 2) if spread else 0.5
            for pair in range(pairs):
                ends = ("a", "b") if chance.random() < own else ("b", "a")
                choices.append(Choice(f"r{rater}", f"p{pair}", f"p{pair}", "c", "q", *ends, 3))
        (one,) = compared(choices, "ab")
        found.append((one.p_raters, one.p_chi_square, one.p_binomial))
    return np.array(found)


def test_coin_flips_have_even_p_values():
    found = p_values(0, 400)
    for level in (0.05, 0.2, 0.5):
        shares = (found <= level).mean(axis=0)
        assert (shares <= level + 0.05).all(), "no test finds more than there is"
        assert (shares >= level - 0.15).all()


def test_raters_with_tastes_of_their_own_mislead_all_tests_but_that_by_raters():
    raters, chi, binomial = (p_values(0.3, 400) <= 0.05).mean(axis=0)
    assert raters < 0.09
    assert chi > 0.2
    assert binomial > 0.15


def test_intervals_by_raters_hold_the_truth_and_those_of_independent_choices_do_not():
    chance = random.Random(3)  # noqa: S311 no secret
    size, held = 1 / 0.15 - 1, np.zeros(2)
    for _ in range(300):
        choices = []
        for rater in range(10):
            own = chance.betavariate(0.65 * size, 0.35 * size)
            for pair in range(10):
                ends = ("a", "b") if chance.random() < own else ("b", "a")
                choices.append(Choice(f"r{rater}", f"p{pair}", f"p{pair}", "c", "q", *ends, 3))
        (one,) = compared(choices, "ab")
        intervals = (one.clustering.interval, one.interval)
        held += [low <= 0.65 <= high for low, high in intervals]
    raters, independent = held / 300
    assert raters > 0.92
    assert independent < 0.85


@given(st.integers(0, 10**6), st.sets(st.integers(0, 11)))
def test_the_sides_of_clips_change_nothing(tmp_path_factory, seed, swapped):
    study = study_of(lines=12, seed=seed)
    submissions = crowd(study, 5, 0.7, spread=0.2, seed=seed)
    before = comparison_of(tmp_path_factory.mktemp("study"), study, submissions)
    kept = {len({a["choice"] for a in one["answers"]}) for one in submissions}
    other = {"left": "right", "right": "left"}
    names = {study["pairs"][n]["pair"] for n in swapped}
    for pair in study["pairs"]:
        if pair["pair"] in names:
            pair["left"], pair["right"] = pair["right"], pair["left"]
    for one in submissions:
        for answer in one["answers"]:
            if answer["pair"] in names:
                answer["choice"] = other[answer["choice"]]
    rules = comparison_of(tmp_path_factory.mktemp("study"), study, submissions)
    kept |= {len({a["choice"] for a in one["answers"]}) for one in submissions}
    if kept == {2}:  # nobody is set aside for taking one side
        assert rules == before


@given(st.integers(1, 80), st.integers(1, 80))
def test_naming_the_methods_the_other_way_mirrors_the_shares(wins, losses):
    choices = choices_of((wins, losses))
    (one,), (two,) = compared(choices, ("ours", "theirs")), compared(choices, ("theirs", "ours"))
    assert two.share == pytest.approx(1 - one.share)
    assert two.difference == pytest.approx(-one.difference)
    assert two.interval == pytest.approx((1 - one.interval.high, 1 - one.interval.low))
    for name in ("chi_square", "p_chi_square", "p_binomial", "p_raters", "p_lines", "agreement"):
        assert getattr(two, name) == pytest.approx(getattr(one, name))


# Power


@given(st.integers(1, 120), st.floats(0.02, 0.98))
def test_power_counts_every_significant_outcome(choices, share):
    wanted = sum(
        stats.binom.pmf(k, choices, share)
        for k in range(choices + 1)
        if stats.binomtest(k, choices).pvalue <= 0.05
    )
    assert exact_power(choices, share, 0.05) == pytest.approx(wanted, abs=1e-9)


@given(
    st.sampled_from((0.55, 0.6, 0.65, 0.7, 0.8, 0.9, 0.3)),
    st.sampled_from((0.5, 0.8, 0.9, 0.99)),
    st.sampled_from((0.01, 0.05, 0.1)),
)
def test_the_choices_needed_are_the_fewest_from_which_on_power_stays(share, power, alpha):
    needed = choices_needed(share, power, alpha)
    assert exact_power(needed - 1, share, alpha) < power
    assert all(exact_power(needed + n, share, alpha) >= power for n in range(150))


def test_choices_needed_are_near_the_normal_approximation():
    # Fleiss, Statistical Methods for Rates and Proportions: 194 for 60 % at 80 % power, without
    # the correction for continuity; the exact test wants a little more
    assert 194 <= choices_needed(0.6, 0.8, 0.05) <= 220


def test_a_design_and_what_it_is_for_answer_each_other():
    plan = plan_study(PowerQuestion(0.6, pairs=20))
    (row,) = plan.rows
    assert row.power >= 0.8
    assert effective_choices(row.raters - 1, 20, 0.1) < plan.choices <= row.effective
    back = plan_study(PowerQuestion(0.6, raters=row.raters))
    assert back.rows[0].pairs <= 20
    (given_,) = plan_study(PowerQuestion(0.6, raters=row.raters, pairs=20)).rows
    assert given_ == row


def test_a_rater_of_perfect_likeness_is_worth_one_choice():
    assert effective_choices(30, 40, 1.0) == 30
    assert effective_choices(30, 40, 0.0) == 1200


@pytest.mark.parametrize(("question", "told"), [
    (PowerQuestion(0.5), "differs from 0.5"),
    (PowerQuestion(1.2), "between 0 and 1"),
    (PowerQuestion(float("nan")), "between 0 and 1"),
    (PowerQuestion(0.6, power=1.0), "`power=1`"),
    (PowerQuestion(0.6, alpha=0.0), "`alpha=0`"),
    (PowerQuestion(0.6, correlation=-0.1), "`correlation=-0.1`"),
    (PowerQuestion(0.6, raters=0), "`raters=0`"),
    (PowerQuestion(0.6, pairs=-1), "`pairs=-1`"),
    (PowerQuestion(0.6, raters=10**6, pairs=10**6), "fewer raters or pairs"),
    (PowerQuestion(0.6, raters=20), "take at least 22 raters"),
    (PowerQuestion(0.505, power=0.999, alpha=0.001), None),
])  # fmt: skip
def test_questions_without_an_answer_are_told(question, told):
    if told is None:
        assert plan_study(question).choices > 200_000
        return
    with pytest.raises(LipsyncError, match=told.replace(".", r"\.")):
        plan_study(question)


def test_the_fewest_raters_that_are_told_are_enough():
    assert plan_study(PowerQuestion(0.6, raters=22)).rows[0].power >= 0.8


@full
def test_a_planned_study_has_its_power():
    plan = plan_study(PowerQuestion(0.65, pairs=10, correlation=0.15))
    row = plan.rows[0]
    chance = random.Random(9)  # noqa: S311 no secret
    size = 1 / 0.15 - 1
    found = 0
    for _ in range(600):
        differences = []
        for _ in range(row.raters):
            own = chance.betavariate(0.65 * size, 0.35 * size)
            differences.append(2 * sum(chance.random() < own for _ in range(10)) - 10)
        found += sign_flips(differences) <= 0.05
    assert found / 600 == pytest.approx(row.power, abs=0.06)
