"""The cache of compiled pairs: exact results, and no use of doubtful files."""

import ast
import json
import os
import random
import shutil
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from face_models import face
from lanes import full
from packs_tree import plant, put

import lipsync_lang as ll
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.library import Library
from lipsync_lang.pipeline.tables import Tables
from lipsync_lang.resolver import cache, rigging
from lipsync_lang.resolver.compile import compile_pair

SCHEDULE = ll.Schedule(("P", "Y", "no", "P"), [0, 0.1, 0.25, 0.4, 0.5], notation="first")
PAIR = ("child", "anna")
BETTER = "kind: poseset\nformat: 1\nname: better\nextends: face\nposes: {wide: {}, zz: {}}\n"


@pytest.fixture
def store(tmp_path, monkeypatch):
    """An empty cache, and a project with small packs as the current folder."""
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.chdir(plant(tmp_path / "project"))
    return tmp_path / "cache"


def warm(language="child", character="anna", paths=()):
    """Return True if the cache has the pair."""
    return cache.load(language, character, tuple(Path(p) for p in paths)) is not None


def fill(*pair, **rest):
    """Resolve a pair twice, and return the cached pair."""
    ll.resolve(*(pair or PAIR), **rest)
    assert warm(*(pair or PAIR), **rest)


def only(store):
    (path,) = store.glob("*.pair")
    return path


def assert_alike(one, other):
    """Compare two compiled pairs to the last bit."""
    for field in fields(one):
        if field.name != "tables":
            assert getattr(one, field.name) == getattr(other, field.name), field.name
    for field in fields(Tables):
        left, right = getattr(one.tables, field.name), getattr(other.tables, field.name)
        if field.name == "contacts":
            assert len(left) == len(right)
            pairs = [(vars(a), vars(b)) for a, b in zip(left, right, strict=True)]
            for name in ("phonemes", "floor", "ceiling"):
                assert all(np.array_equal(a[name], b[name]) for a, b in pairs)
        elif isinstance(left, np.ndarray):
            assert left.dtype == right.dtype
            assert np.array_equal(left, right), field.name
        else:
            assert left == right, field.name


# Warm


@pytest.mark.usefixtures("store")
def test_the_pose_set_of_a_model_is_chosen_once_until_another_fits_better(monkeypatch):
    face(Path("head.glb"), "open", "wide", "zz")
    first = ll.resolve("child", "head.glb").compiled
    with monkeypatch.context() as patch:
        patch.setattr(rigging, "best_match", None)
        assert_alike(ll.resolve("child", "head.glb").compiled, first)
    assert_alike(ll.resolve("child", "head.glb", cache=False).compiled, first)
    put(Path(), "posesets/better/poseset.yaml", BETTER)
    assert ll.resolve("child", "head.glb").compiled.poseset == "better" != first.poseset
    face(Path("head.glb"), "open", "wide")
    assert ll.resolve("child", "head.glb").compiled.poseset == first.poseset


@pytest.mark.parametrize("pair", [PAIR, ("parent", "face"), ("qaa-XX", "anna")])
def test_warm_equals_cold_exactly(pair, store):
    cold = compile_pair(Library(), *pair)
    fill(*pair)
    assert only(store).is_file()
    assert_alike(cold, cache.load(*pair, ()))


@full
def test_the_packs_of_the_program_are_kept_exactly(store, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cold = compile_pair(Library(), "english", "facefx")
    fill("en", "facefx")
    assert_alike(cold, cache.load("en", "facefx", ()))
    assert only(store)


def test_a_warm_performance_is_the_same_to_the_last_bit(store):
    cold = ll.resolve(*PAIR).perform(SCHEDULE)
    kept = ll.resolve(*PAIR).perform(SCHEDULE)
    fresh = ll.resolve(*PAIR, cache=False).perform(SCHEDULE)
    assert np.array_equal(cold.weights, kept.weights)
    assert np.array_equal(cold.weights, fresh.weights)
    assert cold.explain(0.2) == kept.explain(0.2)
    assert only(store)


def test_the_report_of_a_pair_is_kept_alone(store):
    assert cache.load_report(*PAIR, ()) is None
    cold = ll.resolve(*PAIR).report
    assert cold == cache.load_report(*PAIR, ())
    assert cache.load_report("child", "nobody", ()) is None
    put(Path(), "posesets/face/poseset.yaml", "kind: poseset\n")
    assert only(store).is_file()
    assert cache.load_report(*PAIR, ()) is None


def test_folders_without_packs_share_the_cache(store, tmp_path, monkeypatch):
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        ll.resolve("english", "rhubarb")
        ll.resolve("english", "rhubarb", paths=[tmp_path / name])
    assert only(store)
    monkeypatch.chdir(plant(tmp_path / "owner"))
    assert not warm("english", "rhubarb"), "a project may have packs of these names"


CHECK = """
import sys
from lipsync_lang.cli import main
code = main(["run", "-l", "child", "-c", "anna", "--schedule", "line.json", "-o", "a.csv"])
print(code, *sorted(sys.modules))
"""


@full
def test_a_warm_run_reads_no_yaml(store):
    put(Path(), "line.json", '[{"label": "P", "start": 0, "end": 0.2}]')
    loaded = []
    for _ in range(2):
        command = [sys.executable, "-c", CHECK]
        done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
        code, *modules = done.stdout.split()
        assert code == "0", done.stderr
        loaded.append(set(modules))
    assert {"ruamel.yaml", "pydantic"} <= loaded[0], "the first run was to be cold"
    assert not {"ruamel.yaml", "pydantic", "platformdirs", "praatio"} & loaded[1]
    assert only(store)


def test_gaps_and_motion_are_asked_for_anew(store):
    put(Path(), "posesets/bare/poseset.yaml", BARE)
    ll.resolve("parent", "bare", gaps="rest")
    assert warm("parent", "bare")
    with pytest.raises(ll.LipsyncError, match="bare has no curves for"):
        ll.resolve("parent", "bare").stream()
    assert ll.resolve("parent", "bare", gaps="rest", motion={"window": 0.2}).motion.window == 0.2
    assert only(store)


BARE = "kind: poseset\nformat: 1\nname: bare\nposes: {open: {}}\n"


def test_the_cache_can_be_turned_off(store, monkeypatch):
    ll.resolve(*PAIR, cache=False)
    for word in ("off", ""):
        monkeypatch.setenv(cache.CACHE_VARIABLE, word)
        ll.resolve(*PAIR)
    assert not store.exists()
    assert not Path("off").exists()


def test_the_oldest_pairs_are_forgotten(store, monkeypatch):
    for number, (language, character) in enumerate([PAIR, ("child", "face"), ("parent", "face")]):
        there = set(store.glob("*.pair"))
        ll.resolve(language, character)
        (path,) = set(store.glob("*.pair")) - there
        os.utime(path, (number, number))
    monkeypatch.setattr(cache, "MAX_CACHE_BYTES", sum(p.stat().st_size for p in {*there, path}) - 1)
    path.unlink()
    ll.resolve("parent", "face")
    assert len(list(store.glob("*.pair"))) == 2
    assert not warm("child", "anna")
    assert warm("child", "face")
    assert warm("parent", "face")


def test_a_pair_larger_than_the_cache_is_kept_alone(store, monkeypatch):
    monkeypatch.setattr(cache, "MAX_CACHE_BYTES", 1)
    fill()
    fill("child", "face")
    assert only(store)


def arrays_of(tables):
    stored = [vars(tables), *map(vars, tables.contacts), *(b._asdict() for b in tables.styles)]
    return [a for one in stored for a in one.values() if isinstance(a, np.ndarray)]


@pytest.mark.parametrize("pair", [PAIR, ("parent", "face")])
def test_nobody_writes_into_tables_cold_or_warm(pair, store):
    fill(*pair)
    for compiled in (compile_pair(Library(), *pair), cache.load(*pair, ())):
        found = arrays_of(compiled.tables)
        assert len(found) >= 6
        assert not any(array.flags.writeable for array in found)
    assert only(store)


@pytest.mark.skipif(os.name != "posix", reason="modes of folders are POSIX")
def test_the_cache_is_its_owners_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(plant(tmp_path / "project"))
    monkeypatch.delenv(cache.CACHE_VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(cache, "folder", lambda: tmp_path / "own")
    (tmp_path / "own").mkdir(mode=0o755)
    ll.resolve(*PAIR)
    assert (tmp_path / "own").stat().st_mode & 0o777 == 0o700
    monkeypatch.setenv(cache.CACHE_VARIABLE, "named")
    monkeypatch.setattr(cache, "folder", lambda: tmp_path / "made")
    ll.resolve(*PAIR)
    assert (tmp_path / "made").stat().st_mode & 0o777 == 0o700


# Stale


def files_of(pair):
    library = Library()
    compile_pair(library, *pair)
    return sorted(library.files)


def test_every_file_that_was_read_counts(store):
    ipa = (built_in() / "languages/ipa.yaml").read_text(encoding="utf-8")
    put(Path.cwd(), "languages/ipa.yaml", ipa)
    found = files_of(PAIR)
    names = {Path(path).relative_to(Path.cwd()).as_posix() for path in found}
    assert names >= {
        "languages/common.yaml",
        "languages/ipa.yaml",
        "languages/parent.yaml",
        "languages/child.yaml",
        "posesets/face/poseset.yaml",
        "posesets/face/banks/common.yaml",
        "characters/anna.yaml",
        "characters/anna-bank.yaml",
    }
    fill()
    for path in map(Path, found):
        content = path.read_bytes()
        path.write_bytes(content + b"# seen\n")
        assert not warm(), path
        path.write_bytes(content)
        assert warm(), "the same content is as good as new"
        path.unlink()
        assert not warm(), path
        path.mkdir()
        assert not warm(), path
        path.rmdir()
        path.write_bytes(content)
    assert only(store)


ADDED = {
    "a language of that name": "languages/child.yaml",
    "its parent": "languages/parent.yaml",
    "the common phonemes": "languages/common.yaml",
    "the character": "characters/anna.yaml",
    "the pose set": "posesets/face/poseset.yaml",
    "a bank": "posesets/face/banks/more.yaml",
    "a rig": "posesets/face/rigs/more.yaml",
}


@pytest.mark.parametrize("name", ADDED.values(), ids=ADDED)
@pytest.mark.parametrize("how", ["path", "variable"])
def test_a_pack_that_is_found_earlier_counts(name, how, store, tmp_path, monkeypatch):
    more = tmp_path / "more"
    more.mkdir()
    paths = [more] if how == "path" else []
    if how == "variable":
        monkeypatch.setenv("LIPSYNC_LANG_PATH", str(more))
    fill(paths=paths)
    put(more, name, "kind: nothing\n")
    assert not warm(paths=paths)
    assert only(store)


def test_a_bank_that_is_added_or_deleted_counts(store):
    fill()
    text = "kind: bank\nformat: 1\nname: more\nposeset: face\nbigrams: {a-a: {curves: {}}}\n"
    put(Path(), "posesets/face/banks/more.yaml", text)
    assert not warm()
    layers = ll.resolve(*PAIR).report.layers
    fill()
    Path("posesets/face/banks/more.yaml").unlink()
    assert not warm()
    assert ll.resolve(*PAIR).report.layers != layers
    assert only(store)


def test_a_character_named_like_its_pose_set_counts(store):
    fill("child", "face")
    text = "kind: character\nformat: 1\nname: face\nposeset: face\nmotion: {speed_limit: 5}\n"
    put(Path(), "characters/face.yaml", text)
    assert not warm("child", "face")
    assert ll.resolve("child", "face").motion.speed_limit == 5
    assert only(store)


def test_a_language_named_like_a_tag_counts(store):
    fill("qaa-XX", "face")
    put(Path(), "languages/qaa-XX.yaml", "kind: language\nformat: 1\nname: qaa-XX\ntag: qab\n")
    assert not warm("qaa-XX", "face")
    assert only(store)


def test_each_folder_has_its_own_pairs(store, tmp_path, monkeypatch):
    fill()
    monkeypatch.chdir(plant(tmp_path / "elsewhere", "characters/anna-bank.yaml"))
    assert not warm()
    with pytest.raises(ll.LipsyncError, match="anna-bank"):
        ll.resolve(*PAIR)
    assert only(store)


def test_other_code_compiles_anew(store, tmp_path, monkeypatch):
    fill()
    package = Path(ll.__file__).parent
    copy = tmp_path / "package"
    for folder in cache.COMPILERS:
        shutil.copytree(package / folder, copy / folder)
    monkeypatch.setattr(cache, "__file__", str(copy / "resolver" / "cache.py"))
    try:
        cache.compiler.cache_clear()
        assert warm(), "a copy of the same code is the same code"
        for folder in cache.COMPILERS:
            depths = {len(path.parts): path for path in (copy / folder).rglob("*.py")}
            for module in depths.values():
                text = module.read_bytes()
                module.write_bytes(text + b"# changed\n")
                cache.compiler.cache_clear()
                assert not warm(), module
                module.write_bytes(text)
        cache.compiler.cache_clear()
        monkeypatch.setattr(cache, "__version__", "0.0.0")
        assert not warm()
    finally:
        cache.compiler.cache_clear()
    assert only(store)


LOADED = """
import sys
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.compile import compile_pair
for pair in ("english", "facefx"), ("japanese", "crab"), ("espeak:sw", "arkit"):
    compile_pair(Library(project=None), *pair)
print(*(name for name in sys.modules if name.startswith("lipsync_lang.")))
"""


@full
def test_the_digest_covers_all_that_compiling_loads():
    command = [sys.executable, "-c", LOADED]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    rooms = {"/".join(name.split(".")[1:]) for name in done.stdout.split()}
    assert "text/phonology" in rooms
    # the version is in it, too; where extensions bring packs, every warm start looks anew; the
    # rest of the base is for messages and files
    wings = {room for room in rooms if "/" not in room} & {"text", "base", "faces"}
    apart = {room for room in rooms if room.startswith("base/")} | wings
    assert all(room.startswith(cache.COMPILERS) for room in rooms - apart)


# Broken


def test_what_is_cut_off_is_not_believed(store):
    fill()
    whole = only(store).read_bytes()
    for length in {*range(0, len(whole), max(1, len(whole) // 50)), len(whole) - 1}:
        only(store).write_bytes(whole[:length])
        assert not warm(), length
    only(store).write_bytes(whole + b"\0")
    assert not warm()
    only(store).write_bytes(whole)
    assert warm()


def test_what_is_damaged_is_not_believed(store):
    fill()
    whole = only(store).read_bytes()
    chance = random.Random(0)  # noqa: S311 to repeat
    places = [*range(80), *(chance.randrange(len(whole)) for _ in range(200))]
    for place in places:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << chance.randrange(8)
        only(store).write_bytes(damaged)
        assert not warm(), place


def forged(whole, change):
    """Return a cache file with a changed header and a correct checksum."""
    rest = whole[len(cache.MARK) + cache.CHECKSUM :]
    size = int.from_bytes(rest[:8], "little")
    head = json.loads(rest[8 : 8 + size])
    body = rest[8 + size + (-(8 + size) % 64) :]
    change(head)
    text = json.dumps(head).encode()
    made = len(text).to_bytes(8, "little") + text
    made += b"\0" * (-len(made) % 64) + body
    return b"".join(cache.sealed(cache.MARK, [made]))


FORGED = {
    "a shape beyond all numbers": lambda head: head["arrays"]["curves"].__setitem__(1, [10**30]),
    "an offset beyond all numbers": lambda head: head["arrays"]["curves"].__setitem__(2, 10**30),
    "a negative offset": lambda head: head["arrays"]["free"].__setitem__(2, -8),
    "another shape": lambda head: (
        head["arrays"]["thresholds"][1].reverse()
        or head["arrays"]["thresholds"].__setitem__(1, [1, head["arrays"]["thresholds"][1][0] ** 2])
    ),
    "another type": lambda head: head["arrays"]["boundary"].__setitem__(0, "<i8"),
    "a phoneme that is not there": lambda head: head.update(silence=1000),
    "a pose that is not there": lambda head: head.update(at_most=[[0, 99]]),
    "a head too deep": lambda head: head.update(motion=[[[]]]),
}


@pytest.mark.parametrize("change", FORGED.values(), ids=FORGED)
def test_what_is_forged_is_not_believed(change, store):
    fill()
    whole = only(store).read_bytes()
    only(store).write_bytes(forged(whole, lambda _: None))
    assert warm(), "the forger knows the format"
    only(store).write_bytes(forged(whole, change))
    assert not warm()
    assert ll.resolve(*PAIR).perform(SCHEDULE).weights.any()


@pytest.mark.skipif(os.name == "nt", reason="FIFOs of POSIX")
def test_a_pack_that_became_a_pipe_is_not_waited_for(store):
    fill()
    (store / "pipe").mkdir()
    os.mkfifo(store / "pipe" / "pack.yaml")
    endless = [str(store / "pipe" / "pack.yaml"), "/dev/zero"]
    whole = only(store).read_bytes()
    for path in endless:
        changed = forged(whole, lambda head, path=path: head["files"].update({path: ""}))
        only(store).write_bytes(changed)
        assert not warm()


FOREIGN = {
    "nothing": b"",
    "text": b"hello\n",
    "a mark alone": cache.MARK,
    "a mark and zeros": cache.MARK + bytes(1000),
    "json": b"{}",
    "another version": b"lipsync-lang compiled pair, v0.\n" + bytes(1000),
}


@pytest.mark.parametrize("content", FOREIGN.values(), ids=FOREIGN)
def test_what_is_foreign_is_not_believed_and_made_anew(content, store):
    fill()
    only(store).write_bytes(content)
    assert not warm()
    fill()


def test_another_pairs_file_is_not_believed(store):
    fill()
    mine = only(store)
    fill("parent", "face")
    (other,) = set(store.glob("*.pair")) - {mine}
    shutil.copy(other, mine)
    assert not warm()
    assert ll.resolve(*PAIR).language == "child"


def test_a_folder_in_a_files_place_is_left_alone(store):
    fill()
    path = only(store)
    path.unlink()
    path.mkdir()
    assert ll.resolve(*PAIR).perform(SCHEDULE).weights.any()
    assert path.is_dir()


@pytest.mark.parametrize("where", ["file", "file/below", "/dev/null/cache", "x" * 5000])
def test_a_cache_that_cannot_be_is_done_without(where, store, monkeypatch):
    Path("file").touch()
    monkeypatch.setenv(cache.CACHE_VARIABLE, where)
    for _ in range(2):
        assert ll.resolve(*PAIR).perform(SCHEDULE).weights.any()
    assert not store.exists()


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="as root every folder can be read"
)
@pytest.mark.parametrize("mode", [0o000, 0o300, 0o500])
def test_a_closed_cache_folder_is_done_without(mode, store):
    fill()
    store.chmod(mode)
    try:
        assert ll.resolve(*PAIR).perform(SCHEDULE).weights.any()
    finally:
        store.chmod(0o700)


CROWD = """
import sys
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver import cache
from lipsync_lang.resolver.compile import compile_pair

library = Library()
compiled = compile_pair(library, "child", "anna")
print("ready", flush=True)
sys.stdin.readline()
for _ in range(25):
    cache.save(compiled, "child", "anna", library)
    kept = cache.load("child", "anna", ())
    # a file half written is no file
    assert kept is None or (kept.tables.curves == compiled.tables.curves).all()
"""


@full
def test_processes_may_write_at_once(store):
    command = [sys.executable, "-c", CROWD]
    pipe = subprocess.PIPE
    crowd = [
        subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, encoding="utf-8")
        for _ in range(3)
    ]
    for process in crowd:
        assert process.stdout.readline() == "ready\n"
    for process in crowd:
        process.stdin.write("go\n")
        process.stdin.flush()
    for process in crowd:
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors
    assert [path.name for path in store.iterdir()] == [only(store).name], "nothing left behind"
    assert cache.load("child", "anna", ()) is not None


@full
def test_nothing_is_unpickled_or_executed():
    banned = {"pickle", "marshal", "shelve", "dill", "joblib", "cloudpickle"}
    package = Path(ll.__file__).parent
    pickled = {
        "resolver/compiled.py",  # part of a pickle that the caller has chosen to load
        "plugins/cluster/dask_cluster.py",  # batches of a scheduler that the user has named
        "production/builds/workers.py",  # what this build sends to its own processes
    }
    for path in set(package.rglob("*.py")) - {package / name for name in pickled}:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                assert not banned & {alias.name for alias in node.names}, path
            elif isinstance(node, ast.ImportFrom):
                assert node.module not in banned, path
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in {"eval", "exec"}, path
            elif isinstance(node, ast.keyword):
                assert node.arg != "allow_pickle", path
