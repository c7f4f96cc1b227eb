"""Reading of YAML: with libyaml and without, and texts on which parsers and versions differ."""

import re
from pathlib import Path
from random import Random

import pytest
from lanes import full, swept
from test_mutation import FILES, SLIPS, edited

from lipsync_lang.packs.yaml import events
from lipsync_lang.packs.yaml.building import scan
from lipsync_lang.packs.yaml.pack_files import MAX_PACK_BYTES

HERE = Path("here.yaml")
EDITS = 300
PIECE = 400
"""Characters of a pack in which errors are made, so that they are close together."""


def slow(path, content):
    """Scan as if there were no `ruamel.yaml.clib`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(events, "parser_in_c", lambda: None)
        return scan(path, content)


def marks(mark, data):
    """Return every place except those of empty values, which stand behind comments without it."""
    place = None if data is None or data == "" else mark[:2]
    if isinstance(mark.inner, dict):
        inner = [(key, at, marks(one, data[key])) for key, (at, one) in mark.inner.items()]
        return place, inner
    return place, [marks(one, data[number]) for number, one in enumerate(mark.inner or ())]


READ_BY_ONE = re.compile(rb"\w[ \t]*\t[ \t]*\w|^[ \t]*:[ \t\r\n]|\xef\xbb\xbf", re.MULTILINE)
"""Texts that one of the parsers may refuse.

Only libyaml reads tabs between words. Only the parser in Python reads keys without a name, and
marks of byte order within the text.
"""


def assert_same(path, content):
    fast, other = scan(path, content), slow(path, content)
    assert bool(fast.faults) == bool(other.faults)
    if not fast.faults:
        assert repr(fast.data) == repr(other.data)  # repr tells 1 from 1.0 and True, has one NaN
        assert marks(fast.root, fast.data) == marks(other.root, other.data)


def assert_slips_same(path, content):
    known = READ_BY_ONE.search(content)
    if not (known and bool(scan(path, content).faults) != bool(slow(path, content).faults)):
        assert_same(path, content)


@pytest.mark.parametrize(
    "path", swept(FILES, quick=FILES[::20]), ids=lambda path: f"{path.parent.name}/{path.stem}"
)
def test_a_shipped_pack_is_read_the_same_without_libyaml(path):
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
        assert_slips_same(path, text.encode())


@full
def test_slips_in_whole_packs_are_read_the_same():
    for number in range(20):
        assert_slips_same(*edited(number))


# Texts on which versions of YAML differ


def faults(text):
    """Return the code and the place of each fault."""
    return [(one.code, one.line, one.column) for one in scan(HERE, text.encode()).faults]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("a:\n\tb: 1", ("P007", 2, 1)),
        ("-\ta: 1\n\tb: 2", ("P007", 1, 2)),
        ("a: b\u2028c", ("P005", 1, 5)),
        ("a: b\x85  c", ("P005", 1, 5)),
        ("%YAML 1.1\n---\na: no", ("P017", 1, 1)),
        ("%YAML 1.3\n---\na: no", ("P017", 1, 1)),
        ("a: !b c", ("P014", 1, 4)),
    ],
)
def test_what_only_some_versions_of_yaml_read_is_refused(text, fault):
    assert faults(text) == [fault]


@pytest.mark.parametrize(
    "text", ["a:\tb", 'a: "b\tc"', "a: b\tc", "a: |\n  b\n  \tc\n", "a: b #\tc"]
)
def test_a_tab_that_indents_nothing_is_read(text):
    assert faults(text) == []


def test_a_fault_of_a_large_text_is_located():
    assert faults(f"# {'x' * 2**18}\na: [1, 2\nb: 3") == [("P008", 2, 4)]


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("a: {source: http://x.org}", {"a": {"source": "http://x.org"}}),
        ("a: [b?c, d]", {"a": ("b?c", "d")}),
        ("a: [b:c]", {"a": ("b:c",)}),
    ],
)
def test_a_sign_within_a_word_between_brackets_is_read(text, data):
    for words in range(20):  # events that were yielded before are not yielded again
        before = "".join(f"n{n}: [{'x, ' * n}]\n" for n in range(words))
        scanned = scan(HERE, f"{before}{text}\nend: x".encode())
        assert not scanned.faults
        assert scanned.data == {f"n{n}": ("x",) * n for n in range(words)} | data | {"end": "x"}


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
