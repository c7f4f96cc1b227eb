"""YAML as data with places."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.base.errors import PackError
from lipsync_lang.packs.yaml.building import read_yaml, scan
from lipsync_lang.packs.yaml.faults import PackFaults

HERE = Path("here.yaml")


def data(text: str):
    return read_yaml(HERE, text.encode()).data


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"), ("on", "on"), ("yes", "yes"), ("off", "off"), ("1:30", "1:30"),
        ("1_000", "1_000"), ("0b11", "0b11"), ("2024-01-01", "2024-01-01"), ("=", "="),
        ("true", True), ("False", False), ("tRue", "tRue"),
        ("null", None), ("~", None), ("", None), ("nULL", "nULL"),
        ("1", 1), ("-07", -7), ("0o17", 15), ("0x1F", 31), ("+12", 12),
        ("1.5", 1.5), (".5", 0.5), ("1.", 1.0), ("1e3", 1000.0), ("-1.5E-2", -0.015),
        ("-.inf", float("-inf")), ("'1'", "1"), ('"true"', "true"), ('""', ""),
    ],
)  # fmt: skip
def test_scalars_follow_the_core_schema(text, value):
    found = data(f"a: {text}")["a"]
    assert found == value
    assert type(found) is type(value)


def test_keys_are_the_text_of_the_file():
    text = "{2: a, 9.0: b, ~: c, no: d, null: e, '@': f, true: g, 0x1F: h}"
    assert list(data(text)) == ["2", "9.0", "~", "no", "null", "@", "true", "0x1F"]


def test_sequences_are_tuples():
    assert data("- [1, a]\n- {b: []}") == ((1, "a"), {"b": ()})


def test_an_alias_stands_for_its_value():
    assert data("a: &x {b: [1]}\nc: *x\nd: [*x, *x]")["d"] == ({"b": (1,)}, {"b": (1,)})


def test_a_place_is_that_of_the_value_or_of_its_key():
    text = "# first\nposes:\n  open: {title: jaw}\n  list:\n    - 1\n    - é: [0, x]\n"
    source = scan(HERE, text.encode())
    assert source.where(()) == (2, 1)
    assert source.where(("poses",)) == (3, 3)
    assert source.where(("poses",), key=True) == (2, 1)
    assert source.where(("poses", "open", "title")) == (3, 17)
    assert source.where(("poses", "open", "title"), key=True) == (3, 10)
    assert source.where(("poses", "list", 1, "é", 1)) == (6, 14)
    assert source.where(("poses", "list", 1, "é", "x")) == (6, 14)


def test_a_missing_step_stays_on_the_nearest_value():
    source = scan(HERE, b"a:\n  b: [1]\n")
    assert source.where(("a", "x")) == (2, 3)
    assert source.where(("a", "inserted", "b", 0)) == (2, 7)
    assert source.where(("a", "b", 7)) == (2, 6)
    assert source.known(("a", "b", 0, "x")) == 3
    assert source.known(("a", "x", "b")) == 1


def test_reading_goes_on_after_a_duplicate():
    source = scan(HERE, b"a: 1\na: 2\nb: {c: 1, c: 2}\nd: 3\n")
    assert source.data == {"a": 1, "b": {"c": 1}, "d": 3}
    assert [(f.code, f.line, f.column) for f in source.faults] == [("P015", 2, 1), ("P015", 3, 11)]


def test_read_yaml_raises_every_fault():
    with pytest.raises(PackFaults) as caught:
        read_yaml(HERE, b"a: 1\na: 2\na: 3\n")
    assert len(caught.value.faults) == 2


def test_a_missing_file_is_said_to_be():
    with pytest.raises(PackError, match=r"here\.yaml: cannot be read: No such file"):
        read_yaml(HERE)


@pytest.mark.parametrize(
    "bomb",
    [
        "[" * 100_000,
        "{a: " * 100_000,
        "- " * 100_000,
        "? " * 100_000,
        "a:\n" + "".join(" " * n + "a:\n" for n in range(1, 200)),
        "&a " * 100_000,
        "a: " + "'" * 99_999,
        "[" + "a, " * 10 + "&x [" + "*x," * 100,
        "!" * 100_000,
        "%" * 100_000,
        "a: &a [" + "x, " * 1000 + "]\nb: &b [" + "*a, " * 1000 + "]\nc: [" + "*b, " * 1000 + "]",
    ],
    ids=range(11),
)
def test_no_file_takes_the_reader_down(bomb):
    source = scan(HERE, bomb.encode())
    assert source.faults
    assert all(fault.line >= 1 and fault.column >= 1 for fault in source.faults)


NUMBERS = st.integers(-(10**9), 10**9)
PLAIN = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text("ab: #-[]{}'\"\n\té", max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.text("abno~12", min_size=1, max_size=4), inner, max_size=4)
    ),
    max_leaves=20,
)


@given(PLAIN)
def test_what_is_written_is_read(value):
    """JSON is YAML, so values that the standard library writes are read back."""
    import json

    def plain(item):
        if isinstance(item, list):
            return tuple(map(plain, item))
        return {k: plain(v) for k, v in item.items()} if isinstance(item, dict) else item

    assert data(json.dumps(value, ensure_ascii=False)) == plain(value)


@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_any_bytes_are_data_or_located_faults(content):
    source = scan(HERE, content)
    assert source.faults or source.data is not None or content
    assert all(fault.line >= 1 and fault.column >= 1 for fault in source.faults)


@given(st.text("ab:-[]{}&*!|>'\"%#?,\n\t <", max_size=60))
def test_any_punctuation_is_data_or_located_faults(text):
    source = scan(HERE, text.encode())
    lines = text.count("\n") + 1
    assert all(1 <= fault.line <= lines + 1 for fault in source.faults)
