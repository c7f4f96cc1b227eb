"""Archives of outputs: their content byte by byte, without losses."""

import zipfile
from contextlib import suppress
from pathlib import Path
from zlib import crc32

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full

from lipsync_lang.base.errors import OutputError
from lipsync_lang.production.builds import archives
from lipsync_lang.production.builds.archives import members, rewrite, split_archive

NAMES = st.sampled_from(["a.csv", "b.csv", "folder/c.csv", "ü 日本.csv", "z.glb"])
CONTENTS = st.binary(max_size=300) | st.just(b"0.25," * 5000)
CHANGES = st.lists(
    st.tuples(st.dictionaries(NAMES, CONTENTS, max_size=4), st.sets(NAMES, max_size=2)),
    min_size=1,
    max_size=5,
)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "english-crab.zip"


def content(path):
    """Members of an archive, as checked by another reader."""
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


@given(CHANGES)
def test_archives_hold_what_was_put_and_depend_on_nothing_else(tmp_path_factory, changes):
    folder = tmp_path_factory.mktemp("archive")
    path, again = folder / "one.zip", folder / "again.zip"
    known = {}
    for new, drop in changes:
        rewrite(path, new, drop)
        known = {name: data for name, data in known.items() if name not in drop} | new
        assert members(path) == {n: (crc32(data), len(data)) for n, data in known.items()}
    assert path.exists() == bool(known)
    if known:
        assert content(path) == known
        assert [*members(path)] == sorted(known)
        rewrite(again, known)
        assert path.read_bytes() == again.read_bytes(), "of history, nothing is left"
    assert {p.name for p in folder.iterdir()} <= {"one.zip", "again.zip"}


def test_members_come_from_files_too(path, tmp_path):
    (tmp_path / "made").write_bytes(b"1,2\n" * 1000)
    rewrite(path, {"a.csv": tmp_path / "made"})
    one = path.read_bytes()
    rewrite(path, {"a.csv": b"1,2\n" * 1000})
    assert path.read_bytes() == one
    assert content(path) == {"a.csv": b"1,2\n" * 1000}


def test_members_that_stay_are_not_compressed_again(path, monkeypatch):
    rewrite(path, {f"{n}.csv": b"x" * n for n in range(50)})
    compressed = []
    put = zipfile.ZipFile.open
    monkeypatch.setattr(
        zipfile.ZipFile,
        "open",
        lambda self, name, *a, **k: compressed.append(name) or put(self, name, *a, **k),
    )
    rewrite(path, {"7.csv": b"new"}, ["8.csv"])
    assert [info.filename for info in compressed] == ["7.csv"]
    assert len(members(path)) == 49


def test_archives_of_others_are_kept_as_they_are(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr("notes.txt", "of a person")
        archive.comment = b"a comment"
    before = content(path)
    rewrite(path, {"a.csv": b"1"})
    assert content(path) == before | {"a.csv": b"1"}


def offset(data, number):
    """Return the end of the fixed part of a member's row in the directory, with its position."""
    at = -1
    for _ in range(number + 1):
        at = data.index(b"PK\x01\x02", at + 1)
    return data[at + 38 : at + 46]


SOUND = {"a.csv": b"1,2\n" * 100, "b.csv": b"3"}
DAMAGE = {
    "empty": (lambda data: data[:0], "is a damaged archive"),
    "cut": (lambda data: data[:-30], "is a damaged archive"),
    "text": (lambda data: b"hello" * len(data), "is a damaged archive"),
    "moved": (lambda data: b"    " + data[4:], "'a.csv' is not at the position that"),
    "overlapping": (
        lambda data: data.replace(offset(data, 1), offset(data, 0)),
        "its members overlap",
    ),
    "locked": (lambda data: data.replace(b"\x14\0\0\0\x08\0", b"\x14\0\1\0\x08\0"), "encrypted"),
}


@pytest.mark.parametrize(("damage", "words"), DAMAGE.values(), ids=DAMAGE)
def test_a_damaged_archive_is_named_and_left_alone(path, damage, words):
    rewrite(path, SOUND)
    damaged = damage(path.read_bytes())
    path.write_bytes(damaged)
    with pytest.raises(OutputError, match=words) as told:
        rewrite(path, {"c.csv": b"4"})
    assert "move it away; the build makes a new one" in str(told.value)
    assert path.read_bytes() == damaged
    assert [p.name for p in path.parent.iterdir()] == [path.name]


@given(st.integers(0, 400), st.binary(min_size=1, max_size=4))
def test_any_damage_is_read_or_told_in_words(tmp_path_factory, place, wrong):
    path = tmp_path_factory.mktemp("damaged") / "a.zip"
    rewrite(path, SOUND)
    data = path.read_bytes()
    path.write_bytes((data[:place] + wrong + data[place + len(wrong) :])[: len(data)])
    with suppress(OutputError):
        rewrite(path, {"c.csv": b"4"}, ["b.csv"])
        assert "c.csv" in members(path)


def test_a_folder_in_its_place_is_named(path):
    path.mkdir()
    with pytest.raises(OutputError, match=r"english-crab.zip: cannot be read: Is a directory"):
        members(path)


def test_a_failing_write_keeps_the_old_archive(path, monkeypatch):
    rewrite(path, {"a.csv": b"1"})
    before = path.read_bytes()

    def full_disk(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(archives, "put_member", full_disk)
    with pytest.raises(OutputError, match="No space left"):
        rewrite(path, {"b.csv": b"2"})
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_large_members_and_many_take_the_large_format(path, monkeypatch):
    for module in (zipfile, archives):
        monkeypatch.setattr(module, "ZIP64_LIMIT", 1000)
    monkeypatch.setattr(zipfile, "ZIP_FILECOUNT_LIMIT", 3)
    known = {f"{n}.csv": bytes(range(256)) * 8 * n for n in range(6)}
    rewrite(path, known)
    rewrite(path, {"9.csv": b"9" * 5000})
    assert content(path) == known | {"9.csv": b"9" * 5000}
    assert b"PK\x06\x06" in path.read_bytes(), "the end of the large format"


@full
def test_an_archive_holds_more_than_65535_members(path):
    known = {f"{n:06}.csv": b"%d" % n for n in range(70_000)}
    rewrite(path, known)
    rewrite(path, {"x.csv": b"x"}, ["000000.csv"])
    assert len(members(path)) == 70_000
    assert content(path)["069999.csv"] == b"69999"


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ("takes/english-crab.zip/l1.csv", ("takes/english-crab.zip", "l1.csv")),
        ("a.ZIP/b/c.zip/d.csv", ("a.ZIP", "b/c.zip/d.csv")),
        ("takes/l1.zip", None),
        ("takes/l1.csv", None),
        ("zip/l1.csv", None),
    ],
)
def test_a_path_is_split_at_its_archive(given, found):
    assert split_archive(given) == found
    assert found is None or str(Path(*found)) == given
