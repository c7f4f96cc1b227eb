"""Texts that are written by templates, in the words that no command shows every day."""

from dataclasses import replace

from lipsync_lang.animations.explanation import Explanation
from lipsync_lang.packs.library import Library
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.resolver.bank_diff import diff_banks, told


def test_an_explanation_of_heard_sound_names_the_likeliest_labels():
    likely = (("AA", 0.5), ("AE", 0.25), ("AO", 0.1), ("AH", 0.08), ("EH", 0.066), ("IY", 0.004))
    one = Explanation(1.0, 24, "AA", 0, "aa", 0.9, 1.1, "map", (), (), likely=likely)
    assert str(one).split("\n") == [
        "1.000 s (frame 24): AA as aa, 0.900 to 1.100 s, in 'map'",
        "  likeliest by sound: AA 0.50, AE 0.25, AO 0.10, AH 0.08, EH 0.07",
    ]


def test_a_report_of_a_pair_lists_gaps_by_their_first_phoneme():
    report = replace(resolve("english", "crab").report, gaps=("aa-d", "aa-f", "d-aa"))
    assert str(report).split("\n")[-3:] == [
        "3 bigrams without curves:", "  aa-  d f", "  d-  aa",
    ]  # fmt: skip


def test_a_comparison_counts_the_bigrams_that_it_leaves_out():
    found = diff_banks(Library(), "english", "crab")
    left = f"... and {len(found.named) - 1} that differ less (--all)"
    assert told(found, 1).split("\n")[-1] == left
    assert "(--all)" not in told(found)
