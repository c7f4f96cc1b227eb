"""Proposal files: written files are read again, and faulty ones are refused with the place."""

from io import StringIO

import pytest

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.plugins.capture.fit_file import (
    FITTED,
    FitFold,
    FitItem,
    FitProposal,
    FitVerdict,
    SetAside,
    read_fit,
    write_fit,
)

ITEMS = (
    FitItem(
        item="targets.ow",
        value=[{"open": 0.5, "W": 0.4, "dominance": {"W": 2.0}}, {"W": 0.9, "dominance": 3}],
        was=[{"open": 0.3}],
        occurrences=37,
        residual_before=0.08,
        residual_after=0.05,
        confidence=0.83,
    ),
    FitItem(item="softness.jaw", value=0.05, was=0.04, occurrences=900, confidence=0.9),
    FitItem(item="anticipate.W", value=0.1, occurrences=40),
    FitItem(item="motion.speed_limit", value=14, was=16.0),
    FitItem(
        item="bigrams.l-ow",
        value={"boundary": 0.45, "curves": {"open": [[0, 0], [0.5, 0.25], [1, 0.5]]}},
    ),
)


def proposal(**others):
    verdict = FitVerdict(
        accepted=True,
        why="better on 3 of 3 lines",
        folds=(FitFold(held_out="one", by="line", before=0.081, after=0.066, frames=400),),
    )
    fields = {
        "language": "german", "character": "anna", "poseset": "facefx", "lines": 3,
        "seconds": 14.2, "speakers": ("a",), "verdict": verdict, "items": ITEMS,
        "remarks": ("Die Mütze „ruckt“",), "set_aside": (SetAside(line="x", why="silence"),),
    }  # fmt: skip
    return FitProposal(**fields | others)


def written(some=None):
    out = StringIO()
    write_fit(out, some or proposal())
    return out.getvalue()


def put(folder, text):
    path = folder / "fit.json"
    path.write_text(text, "utf-8")
    return path


def test_a_proposal_survives_its_file(tmp_path):
    assert {item.kind for item in ITEMS} == set(FITTED)
    assert read_fit(put(tmp_path, written())) == proposal()


def test_every_item_has_a_line_of_its_own():
    lines = written().splitlines()
    assert all(any(f'"{item.item}"' in line for line in lines) for item in ITEMS)


def test_lists_and_tuples_state_the_same_value():
    (target,) = (FitItem(item="targets.a", value=value).value for value in ([{"open": 1}],))
    assert target == FitItem(item="targets.a", value=({"open": 1},)).value


DAMAGED = {
    "nan": ('"confidence": 0.83', '"confidence": NaN', "must be a number"),
    "huge": ('"confidence": 0.83', '"confidence": 1e999', "must be a finite number"),
    "weight": ('"W": 0.9', '"W": 1.9', "`W` must be at most 1"),
    "dominance": ('"dominance": 3', '"dominance": -3', "at least 0"),
    "seconds": ('"value": 0.05', '"value": 5.0', "at most 0.2"),
    "speed": ('"value": 14', '"value": 1000000', "at most 1000"),
    "text": ('"value": 0.05', '"value": "soft"', "must be a number"),
    "null": ('"value": 0.05', '"value": null', "must be a number"),
    "curve": ("[0.5, 0.25]", "[1.5, 0.25]", "at most 1"),
    "times": ("[[0, 0], [0.5", "[[0.9, 0], [0.5", "times fall"),
    "kind": ("softness.jaw", "softnes.jaw", "not an item of a fit"),
    "setting": ("motion.speed_limit", "motion.warp", "speed_limit"),
    "bigram": ("bigrams.l-ow", "bigrams.low", "not a bigram"),
    "phoneme": ("targets.ow", "targets.OW", "malformed"),
    "twice": ("anticipate.W", "softness.jaw", "two values"),
    "field": ('"occurrences": 37', '"occurences": 37', "did you mean 'occurrences'"),
    "by": ('"by": "line"', '"by": "word"', "must be one of line, speaker"),
    "truncated": (" ]\n}\n", "", "fit.json"),
    "later": ('"format": 1', '"format": 2', "newer version"),
    "other": ('"kind": "fit"', '"kind": "bank"', "not a result of a fit"),
    "list": ("{\n", "[{\n", "fit.json"),
    "verdict": ('"accepted": true', '"accepted": "yes"', "true or false"),
}


@pytest.mark.parametrize("name", sorted(DAMAGED))
def test_a_damaged_proposal_is_refused_with_its_place(name, tmp_path):
    old, new, message = DAMAGED[name]
    text = written()
    assert old in text
    path = put(tmp_path, text.replace(old, new, 1))
    with pytest.raises(LipsyncError, match=message) as caught:
        read_fit(path)
    assert str(path.name) in str(caught.value)


def test_a_fault_names_line_and_column(tmp_path):
    text = written().replace('"W": 0.9', '"W": 1.9')
    line = next(n for n, row in enumerate(text.splitlines(), 1) if '"W": 1.9' in row)
    with pytest.raises(LipsyncError, match=rf"fit\.json:{line}:\d+: P104"):
        read_fit(put(tmp_path, text))


def test_a_huge_file_is_refused_unread(tmp_path):
    with pytest.raises(LipsyncError, match="larger than 1 MB"):
        read_fit(put(tmp_path, written() + " " * 2**20))


def test_nothing_that_cannot_be_read_is_made():
    with pytest.raises(ValueError, match="finite"):
        FitItem(item="softness.jaw", value=float("nan"))
