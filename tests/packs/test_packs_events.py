"""The two parsers of YAML: both read the same packs."""

from pathlib import Path
from random import Random

import pytest
from lanes import full, swept
from test_mutation import FILES, SLIPS, edited

from lipsync_lang.packs.yaml import events
from lipsync_lang.packs.yaml.events import MAX_SLOW_CHARS, by_libyaml, by_ruamel, parsers
from lipsync_lang.packs.yaml.source import MAX_PACK_BYTES, scan

HERE = Path("here.yaml")
EDITS = 300
PIECE = 400
"""Characters of a pack in which errors are made, so that they are close together."""


def slow(path, content):
    """Scan with only ruamel.yaml, as if PyYAML had no libyaml."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(events, "has_libyaml", lambda: False)
        return scan(path, content)


def marks(mark, data):
    """Return every place except those of empty values: ruamel.yaml puts some behind comments."""
    place = None if data is None or data == "" else mark[:2]
    if isinstance(mark.inner, dict):
        inner = [(key, at, marks(one, data[key])) for key, (at, one) in mark.inner.items()]
        return place, inner
    return place, [marks(one, data[number]) for number, one in enumerate(mark.inner or ())]


def assert_same(path, content):
    fast, other = scan(path, content), slow(path, content)
    assert fast.faults == other.faults
    assert repr(fast.data) == repr(other.data)  # repr tells 1 from 1.0 and True, and has one NaN
    assert marks(fast.root, fast.data) == marks(other.root, other.data)


def used(text):
    """Return the parsers that run for a text, by patching both."""
    seen = []
    with pytest.MonkeyPatch.context() as patch:
        for one in (by_libyaml, by_ruamel):
            patch.setattr(events, one.__name__, lambda text, one=one: seen.append(one) or one(text))
        scan(HERE, text.encode())
    return seen


def test_libyaml_is_here():
    """Without it, this module compares ruamel.yaml with itself."""
    assert events.has_libyaml()


@pytest.mark.parametrize(
    "path", swept(FILES, quick=FILES[::20]), ids=lambda path: f"{path.parent.name}/{path.stem}"
)
def test_a_shipped_pack_is_read_by_libyaml_alone_and_the_same(path):
    assert used(path.read_text("utf-8")) == [by_libyaml]
    assert_same(path, path.read_bytes())


@pytest.mark.parametrize("first", swept(range(0, EDITS, 100)))
def test_slips_in_a_piece_of_a_pack_are_read_the_same(first):
    for number in range(first, first + 100):
        rng = Random(number)  # noqa: S311 repeatable, not secret
        path = rng.choice(FILES)
        text = path.read_text("utf-8")
        start = rng.choice((0, rng.randrange(len(text))))
        text = text[start : start + PIECE]
        for _ in range(rng.choice((1, 2, 4))):
            text = rng.choice(SLIPS)(rng, text) or "xx"
        assert_same(path, text.encode())


@full
def test_slips_in_whole_packs_are_read_the_same():
    for number in range(20):
        assert_same(*edited(number))


PUNCTUATION = "ab:-[]{}&*!|>'\"%#?,\n\n  \t<é1.\r~=@`\\\u2028\x85"


@full
def test_any_punctuation_is_read_the_same():
    rng = Random(1)  # noqa: S311 repeatable, not secret
    for _ in range(2_000):
        text = "".join(rng.choices(PUNCTUATION, k=rng.randrange(1, 40)))
        assert_same(HERE, text.encode())


DISPUTED = {
    "a tab for a space": "a:\tb",
    "a tab as indentation": "a:\n\tb: 1",
    "a tab in quotes": 'a: "b\tc"',
    "a tab in plain text": "a: b\tc",
    "a line break of YAML 1.1": "a: b\u2028c",
    "a next line": "a: b\x85  c",
    "an old line break": "a: 1\rb: 2",
    "a byte order mark": "a: \ufeffb",
    "a directive": "%YAML 1.1\n---\na: no",
    "an anchor with a colon": "a: &x:y 1",
    "an alias with a colon": "a: *x:y",
    "a comment at a block": "a: |#\n  b",
    "a tag": "a: !b c",
    "a tag that is faulty": "a: !!.!' ",
}


@pytest.mark.parametrize("text", DISPUTED.values(), ids=DISPUTED)
def test_what_the_parsers_dispute_is_for_ruamel_to_judge(text):
    assert used(text)[-1] is by_ruamel
    assert_same(HERE, text.encode())


@pytest.mark.parametrize("text", ["a: 1 # b\tc", "#\ta\na: 1", 'a: "b #\tc"', "a: |\n  b #\tc\n"])
def test_a_tab_in_a_comment_costs_nothing(text):
    assert used(text) == [by_libyaml]
    assert_same(HERE, text.encode())


def large(text):
    """Put a long comment before a text."""
    return f"# {'x' * MAX_SLOW_CHARS}\n{text}"


@pytest.mark.parametrize("text", [*DISPUTED.values(), "a: [", "a: b: c", "{a: 1", "'"])
def test_a_large_text_is_never_read_slowly(text):
    assert by_ruamel not in used(large(text))
    source = scan(HERE, large(text).encode())
    assert [fault.line for fault in source.faults]


def test_a_character_that_a_large_text_may_not_hold_is_named():
    (fault,) = scan(HERE, large('a: "b\tc"').encode()).faults
    assert (fault.code, fault.line, fault.column) == ("P008", 2, 6)
    assert "U+0009" in fault.what


def test_a_fault_of_a_large_text_is_located():
    (fault,) = scan(HERE, large("a: [1, 2\nb: 3").encode()).faults
    assert fault.code == "P008"
    assert fault.line == 2


def test_without_libyaml_ruamel_reads_all(monkeypatch):
    monkeypatch.setattr(events, "has_libyaml", lambda: False)
    assert parsers("a: 1") == (by_ruamel,)
    assert parsers(large("a: 1")) == (by_ruamel,)


# Aliases


def test_aliases_may_not_make_a_file_larger_than_a_file():
    half = "x" * (MAX_PACK_BYTES // 4)
    bomb = f"a: &a {half}\nb: [*a, *a, *a]\n"
    (fault,) = scan(HERE, bomb.encode()).faults
    assert (fault.code, fault.line, fault.column) == ("P011", 2, 13)
    assert scan(HERE, bomb.replace(", *a]", "]").encode()).data["b"] == (half, half)


def test_an_alias_within_an_anchored_value_is_refused_at_once():
    chain = "a0: &a0 [1]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}]\n" for n in range(1, 60))
    (fault,) = scan(HERE, chain.encode()).faults
    assert (fault.code, fault.line) == ("P012", 2)
    assert "'*a0' lies within the value anchored by '&a1'" in fault.what
