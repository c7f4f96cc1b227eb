"""A toy language and its banks, and the coverage of lines in it."""

from collections import Counter

from lipsync_lang.reports.coverage import coverage
from lipsync_lang.text.lines import Line

LANGUAGE = """\
kind: language
format: 1
name: toy
tag: art-x-toy
title: Toy
adds: [yu]
g2p: {engine: rules, notation: ipa, rules: [{from: q, to: t}]}
notations:
  ipa: {a: aa, i: ih, u: w, y: yu, t: d, m: bmp, s: s}
"""

BANK = """\
kind: bank
format: 1
name: common
poseset: facefx
bigrams:
  aa-d: {status: %s, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
  w-d: {status: edited, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
"""

BANK_OF_THREE = """\
kind: bank
format: 1
name: three
poseset: facefx
trigrams:
  d-aa-d: {status: edited, curves: {open: [[0, 0], [0.5, 0.4], [1, 0]]}}
  bmp-ih-s: {curves: {}}
"""


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def bank(folder, status):
    return write(folder / "posesets/facefx/banks/common.yaml", BANK % status)


def lines(*texts):
    return [Line(text, f"a.txt:{number}") for number, text in enumerate(texts, 1)]


def report(*texts, **options):
    return coverage(lines(*texts), "toy", "facefx", **options).reports[0]


def heard(told):
    """Count each bigram, including those with silence."""
    return Counter({one.bigram: one.count for one in (*told.bigrams, *told.silence)})


WRITTEN = LANGUAGE.replace(
    "rules: [", "rules: [{from: да, to: [t, a]}, {from: м, to: m}, {from: и, to: i}, "
) + ("tests:\n- {text: ta mi, phonemes: [d, aa, bmp, ih]}\n")
"""The toy language in Latin letters, with one known word and one spelled word in Cyrillic."""
