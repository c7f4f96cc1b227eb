"""Readers return a result or raise a package error for any input, within a budget.

`LIPSYNC_LANG_FUZZ_SEED` repeats a run of the full lane; the seed is in the name of its tests.
`CONTRIBUTING.md` says how to add an input that failed.
"""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest
from lanes import full, needs_plug_ins, swept
from syntax_trees import modules, walked

from fuzz.oracle import CALLS, CALLS_PER_BYTE, judge
from fuzz.runner import count_for, findings, inputs, judged, warm
from fuzz.targets import HERE, Target, targets
from lipsync_lang import LipsyncError

SEED = int(os.environ["LIPSYNC_LANG_FUZZ_SEED"])  # conftest.py chooses one for all workers
QUICK_INPUTS, FULL_INPUTS = 150, 20_000
GUIDED_SECONDS = 45
TARGETS = targets()
CORPUS = [path for target in TARGETS.values() for path in target.corpus]
assert TARGETS, "a sweep over nothing passes"
assert CORPUS, "a sweep over nothing passes"

NO_TARGET = {
    "authoring/poseset_draft.py": "looks for the first line of a file of its own",
    "packs/banks/write.py": "writes",
    "packs/models/validation.py": "a table of our own",
    "performing/trace.py": "a table of our own",
    "production/builds/archives.py": "archives of our own; damaged ones have tests of their own",
    "production/builds/faces.py": "compares the data of models with files of our own",
    "production/builds/digests.py": "bytes, of any kind",
    "production/builds/build_reports.py": "compares bytes of any kind with a report",
    "production/builds/build_run.py": "copies models, which are a target",
    "production/builds/making.py": "writes",
    "production/builds/project_build.py": "the project, which is a target",
    "production/builds/unchanged.py": "an index of our own, with a digest; damaged ones are tested",
    "schedules/readers/record_formats.py": "a table of our own",
    "text/lines/script_formats.py": "a table of our own",
    "text/lines/markup.py": "a table of our own",
    "packs/yaml/value_text.py": "templates of our own",
    "production/builds/known_projects.py": "a project, and a cache of our own, both with tests",
    "production/builds/timing.py": "a cache of our own, which has tests of its own",
    "reports/coverage/reading_cache.py": "a cache of our own, which has tests of its own",
    "base/presentation": "templates of our own",
    "cli.py": "opens the null device",
    "commands/build.py": "the project, which is a target",
    "base/extensions.py": "looks for names with a pattern",
    "base/files": "what all others read and write with",
    "animations": "templates and names of our own; its readers are targets",
    "authoring/language_check.py": "opens a pair by its name",
    "production/builds/project_folder.py": "templates of our own",
    "base/extras.py": "a table of our own, and the settings of the environment",
    "authoring/language_draft.py": "copies a lexicon, which is a target",
    "authoring/copies.py": "copies packs, which are a target",
    "authoring/new_pack.py": "compares files it has written",
    "commands/output.py": "lines of plain text",
    "commands/shared_options.py": "a table of our own",
    "commands/studio.py": "opens a pair by its name",
    "packs/project.py": "looks for one word; the project is a pack, which is a target",
    "packs/splicing.py": "packs, which are a target",
    "packs/finding.py": "looks for names with a pattern; the packs are targets",
    "packs/yaml/faults.py": "its own table of codes",
    "text/phonology/espeak": "pipes of our own",
    "render/model/scene.py": "pictures within models, which are a target",
    "render/sheet.py": "stills of our own; models are a target",
    "render/staging.py": "writes",
    "render/video.py": "what ffmpeg and we have written",
    "resolver": "the cache of compiled pairs, which has tests of its own",
    "studio/desk.py": "packs, which are a target; a journal of our own, with tests of damaged ones",
    "studio/module_bundle.py": "scripts of our own",
    "studio/routes": "copies packs and models, which are targets; a tour of our own",
    "studio/script_count.py": "a digest of a script, which is a target",
    "studio/server.py": "scripts of our own",
    "studio/workshop.py": "opens a pair by its name",
    "commands/local_server.py": "an address and a secret that it has written itself",
    "commands/doctor_checks.py": "the licence of a model, of which any text may be shown",
    "sound/speech": "what installed engines and models have written; recordings are a target",
}
"""Modules that open files without a target, with the reason. Plug-ins have their own table."""

HAVE_TARGETS = {
    "animations/animation_readers.py",
    "authoring/language_draft.py",
    "production/builds/takes.py",
    "reports/coverage/changes.py",
    "text/lines/line_readers.py",
    "text/lines/xlsx.py",
    "packs/library.py",
    "packs/yaml/building.py",
    "packs/yaml/pack_files.py",
    "text/phonology/g2p/lexicon.py",
    "text/phonology/g2p/orthography_profile.py",
    "faces/rigs/container.py",
    "schedules/timing_file.py",
    "sound/speech/sound.py",
}
"""Modules that open files within the target of another module."""


@pytest.mark.parametrize("name", TARGETS)
def test_every_reader_has_a_sound_file_to_damage(name):
    assert warm(name), f"put a sound file into {TARGETS[name].home}/seeds/{name}"


@needs_plug_ins
def test_every_folder_of_files_belongs_to_a_target():
    for home in {target.home for target in TARGETS.values()}:
        files = (path for kind in ("seeds", "corpus") for path in (home / kind).glob("*/*/*"))
        assert {"/".join(path.parts[-3:-1]) for path in files} <= TARGETS.keys()


def _opens(tree: ast.AST) -> bool:
    names = {"read_bytes", "read_text", "read_input", "input_text", "open"}
    return any(
        isinstance(node, ast.Call)
        and getattr(node.func, "attr", getattr(node.func, "id", "")) in names
        for node in walked(tree)
    )


def opening(folder: str = "") -> set[str]:
    """Return the modules that open files; only those below a folder of the package, if given."""
    return {name for name, tree in modules().items() if name.startswith(folder) and _opens(tree)}


def test_every_module_that_opens_files_has_a_target_or_a_reason():
    found = opening() - opening("plugins/")
    without = {
        name
        for name in found - HAVE_TARGETS
        if not any(name == one or name.startswith(f"{one}/") for one in NO_TARGET)
    }
    assert not without, "give it a target in fuzz/targets.py, or a reason here"
    assert found >= HAVE_TARGETS, "no longer opens files"


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.relative_to(HERE.parent).as_posix())
def test_what_once_failed_is_told_in_words(path):
    name = "/".join(path.parts[-3:-1])
    warm(name)
    assert judged(TARGETS[name], path.read_bytes(), path.suffix) is None


def _mutate(name: str, seed: int, total: int) -> None:
    count = count_for(TARGETS[name], total, TARGETS.values())
    failed = [*findings(TARGETS[name], seed, count)]
    told = "\n".join(f"  input {one.number}: {one.what}" for one in failed[:20])
    again = f"python -m fuzz.runner --target {name} --seed {seed} --inputs {total} --keep"
    assert not failed, f"{len(failed)} of {count} fail:\n{told}\nin tests: {again}"


@pytest.mark.parametrize("name", TARGETS)
def test_damaged_files_are_read_or_told_in_words(name):
    _mutate(name, seed=0, total=QUICK_INPUTS)


@full
@pytest.mark.parametrize("seed", [SEED], ids="seed{}".format)
@pytest.mark.parametrize("name", TARGETS)
def test_many_damaged_files_are_read_or_told_in_words(name, seed):
    _mutate(name, seed, FULL_INPUTS)


# The judge himself


def _raises(error: Exception):
    def read(path: Path) -> None:
        del path
        raise error

    return read


def _works(path: Path) -> None:
    while True:
        path.exists()


def _takes(path: Path) -> None:
    del path
    bytes(200 * 2**20)


def _takes_in_words(path: Path) -> None:
    try:
        _takes(path)
    except MemoryError as error:
        raise LipsyncError("a.csv: is too large") from error


def _fills(path: Path) -> None:
    del path
    assert [bytearray(1_000) for _ in range(10**5)]


def _works_in_haste(path: Path) -> None:
    for _ in range(CALLS + CALLS_PER_BYTE * path.stat().st_size):
        abs(1)


class EndlessError(LipsyncError):
    def __str__(self) -> str:
        return "x" * 10**6


JUDGED = {
    "an error in words": (_raises(LipsyncError("a.csv:1: is empty")), None),
    "a traceback": (_raises(KeyError("x")), "KeyError"),
    "no words": (_raises(LipsyncError("")), "without a message"),
    "too many words": (_raises(EndlessError()), "a message of 1000000 characters"),
    "a warning": (_raises(UserWarning("doubtful")), "UserWarning"),
    "too much work": (_works, "too much work"),
    "too much work in no time": (_works_in_haste, "too much work"),
    "too much memory": (_takes, "too much memory: 200 MB"),
    "too much memory, in words": (_takes_in_words, "too much memory: 200 MB"),
    "too much memory, in pieces": (_fills, "too much memory: "),
}


@pytest.mark.parametrize("name", swept(JUDGED, quick=JUDGED.keys() - {"too much work"}))
def test_the_judge_sees(name, tmp_path):
    path = tmp_path / "line.csv"
    path.write_bytes(b"x")
    read, told = JUDGED[name]
    found = judge(read, path)
    assert found is None if told is None else told in found


def test_a_seed_repeats_its_inputs_and_another_has_others():
    target: Target = TARGETS["timings/json"]
    once, again, others = ([*inputs(target, seed, 20)] for seed in (1, 1, 2))
    assert once == again != others
    assert len({content for _, content, _ in once}) > 15


@full
def test_coverage_guided_inputs_are_read_or_refused():
    """`atheris` looks for inputs that reach new lines, for a while, with a limit of memory."""
    pytest.importorskip("atheris", reason="no atheris: coverage does not guide the fuzzing")
    done = subprocess.run(
        [sys.executable, "-m", "fuzz.guided", str(GUIDED_SECONDS), str(SEED)], check=False,
        cwd=HERE.parent, capture_output=True, encoding="utf-8", errors="replace", timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout + done.stderr)[-5000:]
