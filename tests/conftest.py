"""Fixtures of all tests: folders, a separate cache, and the command line."""

import gc
import json
import os
import re
import signal
import sys
from contextlib import suppress
from importlib.util import find_spec, module_from_spec
from itertools import count
from pathlib import Path
from random import randrange
from tempfile import TemporaryDirectory
from typing import NamedTuple

import lanes  # noqa: F401 its profiles are known before Hypothesis is told which one to take
import pytest
from places import ROOT, TESTS
from shipped import read_once

from lipsync_lang.cli import main
from lipsync_lang.pipeline import kernel
from lipsync_lang.text.lines import read_lines

sys.path.extend({str(module.parent) for module in sorted(TESTS.rglob("*.py"))})
DATA = "LIPSYNC_LANG_TEST_DATA"
"""Environment variable: the folder of foreign recordings and alignments."""

FOLDER_NUMBERS = count()


def pytest_configure(config):
    """Keep tests away from the user's cache and packs, even during collection.

    Garbage is collected more rarely: to do so after every 700 objects takes 6 % of the processor.
    One cache serves the workers of a run: they are started later, and inherit the environment.
    """
    gc.set_threshold(50_000, 20, 100)
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # as in jobs in the background
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(config, "workerinput"):
        return
    cache = TemporaryDirectory(prefix="lipsync-lang-cache-")
    config.add_cleanup(cache.cleanup)
    os.environ["LIPSYNC_LANG_CACHE"] = cache.name
    os.environ.pop("LIPSYNC_LANG_PATH", None)
    os.environ["XDG_STATE_HOME"] = f"{cache.name}/state"
    # Commands that tests start would compile every module again, which takes half of their time.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    seed = 0 if os.environ.get("CI") else randrange(10**6)  # noqa: S311 no secret
    os.environ.setdefault("LIPSYNC_LANG_FUZZ_SEED", str(seed))


def pytest_xdist_auto_num_workers():
    """Give two processors three workers: tests wait for browsers and programs in their time."""
    processors = os.cpu_count() or 1
    return processors + processors // 2


def pytest_collection(session):
    """Let each worker of a fresh clone compile its share of the test modules, and no other."""
    worker = getattr(session.config, "workerinput", {})
    if worker and [Path(one).resolve() for one in session.config.args] == [TESTS]:
        fresh = [path for path in sorted(TESTS.rglob("test_*.py")) if not _is_compiled(path)]
        for path in fresh[int(worker["workerid"][2:]) :: worker["workercount"]]:
            spec = find_spec(path.stem)
            module = module_from_spec(spec)
            module.__builtins__ = {}  # so that its first import fails, and nothing runs
            with suppress(ImportError):
                spec.loader.exec_module(module)


def _is_compiled(path):
    return any(path.parent.glob(f"__pycache__/{path.stem}.*pytest*.pyc"))


def pytest_collection_finish():
    """Leave the collected tests out of every later garbage collection."""
    gc.collect()
    gc.freeze()


def pytest_report_header():
    """Print the seed of the damaged files, which repeats them."""
    return f"LIPSYNC_LANG_FUZZ_SEED={os.environ['LIPSYNC_LANG_FUZZ_SEED']}"


@pytest.fixture(scope="session")
def root():
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def data():
    """The folder of foreign recordings and alignments; tests that need it skip without it."""
    folder = Path(os.environ.get(DATA) or ROOT.parent / "shared" / "data")
    if not (folder / "alignments").is_dir():
        pytest.skip(f"{folder} holds no recordings and alignments; {DATA} names such a folder")
    return folder


@pytest.fixture(scope="session", autouse=True)
def _built_in_packs_are_read_once():
    """Read each built-in pack once in a process."""
    with read_once():
        yield


class Ended(NamedTuple):
    """Result of a command."""

    code: int
    out: str
    err: str


@pytest.fixture
def cli(capsys):
    """Run a command in this process, and return its exit code and its outputs."""

    def run(*arguments):
        capsys.readouterr()
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as exit_:
            code = exit_.code
        assert code in (0, 1, 2)
        ended = Ended(code, *capsys.readouterr())
        assert "Traceback" not in ended.err
        return ended

    return run


@pytest.fixture
def texts_read(tmp_path):
    """Write a script, and read (name, text) of its lines."""

    def run(name, text, **options):
        path = tmp_path / name
        path.write_text(text if isinstance(text, str) else json.dumps(text), "utf-8")
        options = {"remark": lambda _: None, **options}
        return [(line.name, line.text) for line in read_lines(path, **options)]

    return run


@pytest.fixture(params=["compiled", "numpy"])
def arithmetic(request, monkeypatch):
    """Run the stages in the compiled kernel, if there is one, or in numpy."""
    if request.param == "numpy":
        monkeypatch.setattr(kernel, "compiled", None)


@pytest.fixture
def tmp_path(request, tmp_path_factory):
    """An empty folder; pytest's own fixture searches all earlier ones for a free number."""
    name = re.sub(r"\W", "_", request.node.name)[:30]
    return tmp_path_factory.mktemp(f"{name}{next(FOLDER_NUMBERS)}", numbered=False)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Change to an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
