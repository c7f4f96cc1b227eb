"""Plans: how many bigrams are needed, and the fewest sentences that hold them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.reports.coverage import plan

COUNTS = st.lists(st.integers(0, 50), min_size=1, max_size=30)


@given(COUNTS)
def test_running_totals_rise_to_all(counts):
    order = plan.ranked(np.array(counts))
    found = [counts[n] for n in order]
    assert found == sorted((c for c in counts if c), reverse=True)
    needed = list(plan.needed(found).values())
    assert needed == sorted(needed)
    assert needed[-1] == len(found)


@given(COUNTS)
def test_what_is_needed_is_enough_and_no_more(counts):
    found = sorted((c for c in counts if c), reverse=True)
    for share, number in plan.needed(found).items():
        wanted = int(share) * sum(found)
        assert 100 * sum(found[:number]) >= wanted
        assert not number or 100 * sum(found[: number - 1]) < wanted


SETS = st.lists(st.sets(st.integers(0, 20), max_size=8), max_size=25)


def packed(sets):
    starts = np.cumsum([0, *map(len, sets)])
    return np.array([m for s in sets for m in sorted(s)], np.uint16), starts


@given(SETS, st.sets(st.integers(0, 25)))
def test_a_cover_covers_all_that_can_be_and_nothing_twice(sets, wanted):
    members, starts = packed(sets)
    found = plan.cover(members, starts, np.array(sorted(wanted), np.int64))
    there = set().union(*sets) & wanted
    new = [member for _, members in found for member in members]
    assert sorted(new) == sorted(there)
    assert len({number for number, _ in found}) == len(found)
    for number, members in found:
        assert members, "each set has something new"
        assert set(members) <= sets[number]


@given(SETS, st.sets(st.integers(0, 25)))
def test_no_set_of_a_cover_can_be_spared(sets, wanted):
    members, starts = packed(sets)
    chosen = [n for n, _ in plan.cover(members, starts, np.array(sorted(wanted), np.int64))]
    there = set().union(*sets) & wanted
    for one in chosen:
        assert not there <= set().union(*(sets[n] for n in chosen if n != one))


def test_a_cover_takes_the_shorter_of_equals():
    members, starts = packed([{1, 2, 7, 8, 9}, {1, 2}, {3}])
    assert plan.cover(members, starts, np.array([1, 2, 3])) == [(1, [1, 2]), (2, [3])]


def test_a_share_that_is_met_exactly_needs_no_more():
    assert plan.needed([90, 5, 4, 1]) == {"90": 1, "95": 2, "99": 3, "100": 4}
