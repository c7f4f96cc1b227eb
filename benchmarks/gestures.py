r"""Rates of gestures and their cost, beside published figures.

    python benchmarks/gestures.py [TEXTS] [-c POSESET ...] [--json FILE]

TEXTS has a line of text per line, of which the first 100 are spoken by eSpeak NG; by default the
eight lines of `motion.py`, and twelve questions and answers. Silence is ten minutes of rest.

talking, silent   gestures a minute of lines, with lead-in and tail, and of rest
head              two standard deviations of the turns of bones in speech, in degrees
same              share of the lines that repeat with the same bytes
before            share of the lines whose gestures stay up to 1 s before a changed last word
cost              microseconds that gestures add to a line of 40 phonemes without sound; and to one
                  of ten words with marks of stress
"""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import json_figures
import motion
import numpy as np

import lipsync_lang as ll
from lipsync_lang.performing.gesturing import gesture_curves

TALK = (
    "Are you sure?", "Yes, I agree.", "No, not at all.", "Where did you put the key?",
    "I never said that.", "Look at that, over there!", "Right. Let us go home now.",
    "Why should I believe you?", "Because I have never lied to you.", "Well, that is true.",
    "Do you want to stay for dinner?", "Nothing would make me happier.",
)  # fmt: skip
WORDS = "no you did not see the key there my friend"
LINES, FPS, REST_SECONDS, ROUNDS = 100, 60, 600.0, 200


def laid(performer: ll.Performer, line: ll.Schedule) -> tuple[np.ndarray, Counter[str], float]:
    """Return the turns of a line's gestures, their number by name, and its minutes."""
    times = performer.perform(line, FPS).times
    scales = [1.0] * len(performer.gesture_set.shapes)
    curves, found = gesture_curves(performer, line, times, FPS, scales, {})
    own = performer.gesture_set
    turns = curves[:, [channel["node"] is not None for channel in own.channels]]
    counts = Counter(own.shapes[one.gesture.number].name for one in found)
    return turns, counts, float(times[-1] - times[0]) / 60


def rates(performer: ll.Performer, lines: Sequence[ll.Schedule]) -> dict[str, float]:
    """Return the number of each gesture a minute."""
    every = [laid(performer, line) for line in lines]
    minutes = sum(one[2] for one in every)
    counts = sum((one[1] for one in every), Counter())
    names = [shape.name for shape in performer.gesture_set.shapes]
    return {name: counts[name] / minutes for name in names}


def steady(performer: ll.Performer, lines: Sequence[ll.Schedule]) -> tuple[float, float]:
    """Return the shares of lines that repeat, and that stay before a changed last word."""
    count, same, before = len(performer.poses), 0, 0
    for line in lines:
        one, again = (performer.perform(line, gestures="all").weights for _ in range(2))
        same += one.tobytes() == again.tobytes()
        last = line.words[-1]
        words = (*line.words[:-1], replace(last, text="changed"))
        labels = list(line.labels)
        labels[last.first] = "b"
        other = replace(line, words=words, labels=tuple(labels))
        changed = performer.perform(other, gestures="all")
        until = np.searchsorted(changed.times, last.start - 1)
        before += np.array_equal(one[:until, count:], changed.weights[:until, count:])
    return same / len(lines), before / len(lines)


def cost(performer: ll.Performer, line: ll.Schedule) -> float:
    """Return the microseconds that gestures add to a line: the least of several rounds."""

    def least(gestures: str | None) -> float:
        found = []
        for _ in range(ROUNDS):
            begun = perf_counter()
            performer.perform(line, gestures=gestures)
            found.append(perf_counter() - begun)
        return min(found)

    return 1e6 * (least("all") - least(None))


def measured(poseset: str, lines: Sequence[ll.Schedule]) -> dict[str, object]:
    """Measure a pose set."""
    performer = ll.resolve("english", poseset)
    rest = ll.Schedule(("_",), [0, REST_SECONDS])
    turns = np.concatenate([laid(performer, line)[0] for line in lines])
    same, before = steady(performer, lines)
    plain = ll.Schedule(("k", "æ", "t", "b", "iː") * 8, np.arange(41) * 0.08, notation="ipa")
    words = [ll.Word(text, 4 * n, 4 * n + 4) for n, text in enumerate(WORDS.split())]
    worded = replace(plain, labels=("k", "ˈæ", "t", "b", "iː") * 8, words=words)
    return {
        "talking": rates(performer, lines),
        "silent": rates(performer, [rest]),
        "head_degrees": 2 * float(np.sqrt(turns.var(axis=0).sum())),
        "same": same,
        "before": before,
        "cost_us": cost(performer, plain),
        "words_cost_us": cost(performer, worded),
    }


def main(argv: Sequence[str] | None = None) -> int:
    """Print and keep the figures of each pose set."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("texts", type=Path, nargs="?")
    parser.add_argument("-c", dest="posesets", action="append", default=[])
    json_figures.add_option(parser)
    options = parser.parse_args(argv)
    stated = options.texts and options.texts.read_text(encoding="utf-8").splitlines()
    texts = [text for text in stated or (*motion.LINES, *TALK) if text.strip()][:LINES]
    lines = [ll.speak(text, "english") for text in texts]
    figures = {name: measured(name, lines) for name in options.posesets or ["arkit", "facefx"]}
    for name, found in figures.items():
        print(f"{name}, {len(lines)} lines of {sum(line.end for line in lines):.0f} s")
        print("  a minute     talking  silent")
        for gesture, rate in found["talking"].items():
            print(f"  {gesture:<12} {rate:7.1f} {found['silent'][gesture]:7.1f}")
        costs = f"cost {found['cost_us']:.0f} us, {found['words_cost_us']:.0f} us with words"
        print(f"  head {found['head_degrees']:.1f} degrees; {costs}")
        print(f"  same bytes {found['same']:.0%}; same up to 1 s before {found['before']:.0%}")
    json_figures.write_figures(options.json, {"posesets": figures, "lines": len(lines)})
    return 0


if __name__ == "__main__":
    sys.exit(main())
