"""The wheel, as a user gets it: installed alone, run from an empty folder. Takes half a minute."""

import json
import os
import runpy
import shutil
import subprocess
import sys
import tarfile
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest
from lanes import full
from pages import INSTALLED, named, readme_extras
from places import ROOT, TESTS

import lipsync_lang as ll

SCHEDULE = [{"label": "HH", "start": 0, "end": 0.1}, {"label": "AY1", "start": 0.1, "end": 0.3}]
LIBRARIES = {".so", ".pyd"}
"""Suffixes of compiled modules."""

UNREACHABLE = (
    "Temporary failure in name resolution",
    "Failed to establish a new connection",
    "No matching distribution found",
    "Connection refused",
    "Network is unreachable",
    "Read timed out",
    "ProxyError",
)
"""Message of pip if it has no index."""

FOLLOW = """
import sys
from pathlib import Path
sys.path.append(sys.argv[1])
from pages import follow_here
follow_here(Path(sys.argv[2]))
"""
"""Follows a page with the installed package; the folder of the tests comes after it."""

pytestmark = [full, pytest.mark.xdist_group("wheel")]


def run(*command, **rest):
    rest = {"capture_output": True, "encoding": "utf-8", "timeout": 300} | rest
    return subprocess.run([str(part) for part in command], check=False, **rest)


@pytest.fixture(scope="module")
def dist(root, tmp_path_factory):
    """A folder with the wheel and the source archive."""
    folder = tmp_path_factory.mktemp("dist")
    built = run(
        sys.executable, "-m", "build", "--no-isolation", "--wheel", "--sdist", "--outdir", folder,
        cwd=root,
    )  # fmt: skip
    assert built.returncode == 0, built.stdout + built.stderr
    return folder


def installed_in(python, folder, dist, extras=()):
    """Install the wheel into a new environment of a Python; return the folder of its programs.

    The environment needs no pip of its own, and modules are compiled where they are imported:
    each took longer than the rest of the installation.
    """
    made = run(python, "-m", "venv", "--without-pip", folder)
    assert made.returncode == 0, made.stdout + made.stderr
    programs = folder / ("Scripts" if sys.platform == "win32" else "bin")
    (wheel,) = dist.glob("*.whl")
    pip = (sys.executable, "-m", "pip", "--python", programs / "python", "install")
    options = ("--quiet", "--disable-pip-version-check", "--prefer-binary", "--no-compile")
    done = run(*pip, *options, f"{wheel}[{','.join(extras)}]" if extras else wheel)
    if done.returncode and any(words in done.stderr for words in UNREACHABLE):
        pytest.skip("pip reaches no index to install the wheel's requirements from")
    assert done.returncode == 0, done.stderr
    return programs


@pytest.fixture(scope="module")
def installed(dist, tmp_path_factory):
    """Programs of an environment with only the wheel and its requirements."""
    folder = tmp_path_factory.mktemp("environment")
    return installed_in(sys.executable, folder, dist)


@pytest.fixture(scope="module")
def readers(dist, tmp_path_factory):
    """Programs of an environment with the extras of the README; ours if pip reaches no index."""
    folder = tmp_path_factory.mktemp("reader")
    try:
        return installed_in(sys.executable, folder, dist, sorted(readme_extras()))
    except pytest.skip.Exception:
        return Path(sys.executable).parent


@pytest.fixture
def outside(tmp_path, monkeypatch):
    """An empty folder outside the checkout, as the current one."""
    for name in ("PYTHONPATH", "LIPSYNC_LANG_PATH", "VIRTUAL_ENV"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path.with_name("wheel-cache")))
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def start(installed, outside):  # noqa: ARG001 the current folder
    """Run the installed command in an empty folder outside the checkout."""
    return lambda *arguments: run(installed / "lipsync-lang", *arguments)


def hatch_build():
    """Return the module of the build hook."""
    return runpy.run_path(str(ROOT / "hatch_build.py"))


def members(archive):
    """List the files of a wheel or a source archive, without the outer folder of an archive."""
    if archive.suffix == ".whl":
        return set(zipfile.ZipFile(archive).namelist())
    with tarfile.open(archive) as tar:
        return {name.partition("/")[2] for name in tar.getnames()}


def tracked(root, *folders):
    """List the files of some folders of the checkout that belong in a release."""
    found = {path for folder in folders for path in (root / folder).rglob("*") if path.is_file()}
    return {p.relative_to(root).as_posix() for p in found if "__pycache__" not in p.parts}


def test_the_wheel_holds_the_code_and_the_packs_and_nothing_else(dist, root):
    (wheel,) = dist.glob("*.whl")
    packs = {f"lipsync_lang/data/{name}" for name in tracked(root, "languages", "posesets")}
    packs |= {f"lipsync_lang/data/{name}" for name in tracked(root / "docs", "examples")}
    code = {name for name in tracked(root, "lipsync_lang") if Path(name).suffix not in LIBRARIES}
    assert "lipsync_lang/py.typed" in code
    assert "lipsync_lang/data/languages/common.yaml" in packs
    found = members(wheel)
    about = {name for name in found if ".dist-info/" in name}
    compiled = {name for name in found if Path(name).suffix in LIBRARIES}
    assert found - about - compiled == packs | code
    assert any(name.endswith("/licenses/LICENSE") for name in about)


def test_the_wheel_holds_the_kernel_where_there_is_a_compiler(dist, tmp_path):
    (wheel,) = dist.glob("*.whl")
    compiled = {name for name in members(wheel) if Path(name).suffix in LIBRARIES}
    if not compiled:  # only then is it compiled again, which takes 10 s
        assert isinstance(hatch_build()["compiled_or_reason"](tmp_path), str)
        assert wheel.name.endswith("-py3-none-any.whl")
        return
    (library,) = compiled
    assert library.startswith("lipsync_lang/pipeline/_kernel.")
    assert "-cp311-abi3-" in wheel.name


def test_a_failing_compiler_costs_only_speed(root, tmp_path):
    built = run(
        sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", tmp_path,
        cwd=root, env={**os.environ, "CC": "no-such-compiler", "LIPSYNC_LANG_KERNEL": "off"},
    )  # fmt: skip
    assert built.returncode == 0, built.stdout + built.stderr
    assert "no compiled kernel, which costs only speed" in built.stdout + built.stderr
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.endswith("-py3-none-any.whl")
    assert not {name for name in members(wheel) if Path(name).suffix in LIBRARIES}


def test_the_source_archive_holds_what_is_needed_to_build_and_test(dist, root):
    (archive,) = dist.glob("*.tar.gz")
    found = members(archive)
    needed = tracked(root, "lipsync_lang", "languages", "posesets")
    assert found >= {name for name in needed if Path(name).suffix not in LIBRARIES}
    assert found >= {path for path in tracked(root, "tests") if path.endswith(".py")}
    assert found >= {
        "LICENSE",
        "README.md",
        "pyproject.toml",
        "hatch_build.py",
        "Makefile",
        "PKG-INFO",
    }


@pytest.mark.skipif(find_spec("twine") is None, reason="twine is not installed")
def test_twine_accepts_the_wheel_and_the_source_archive(dist):
    archives = [*dist.glob("*.whl"), *dist.glob("*.tar.gz")]
    assert len(archives) == 2
    done = run(sys.executable, "-m", "twine", "check", "--strict", *archives)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("PASSED") == 2


def test_the_installed_program_runs_without_the_checkout(start, root):
    done = start("--version")
    assert done.stdout.startswith(f"lipsync-lang {ll.__version__} (")
    done = start("languages", "list", "--json")
    rows = json.loads(done.stdout)
    assert {path.stem for path in (root / "languages").glob("*.yaml")} - {"common", "ipa"} == {
        row["name"] for row in rows
    }
    for row in rows:
        assert row["origin"] == "built-in"
        assert not Path(row["path"]).is_relative_to(root)
    assert "built-in" in start("posesets", "list").stdout
    assert (start("validate").returncode, start("validate").stdout) == (0, "")


def test_the_installed_program_resolves_and_performs(start, installed):
    assert "441 shared" in start("resolve", "-l", "english", "-c", "facefx").stdout
    Path("line.json").write_text(json.dumps(SCHEDULE))
    command = ("run", "-l", "english", "-c", "facefx", "--schedule", "line.json")
    for _ in ("cold", "warm"):
        done = start(*command, "-o", "a.csv", "-o", "a.json")
        assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert Path("a.csv").read_text().startswith("time_s,open,")
    code = "import lipsync_lang, sys; print(lipsync_lang.__file__, *sys.path, sep='\\n')"
    places = run(installed / "python", "-c", code).stdout
    checkout = str(ROOT)
    assert checkout + os.sep not in places + os.sep


def test_a_project_is_built_below_a_home_with_spaces_and_other_letters(
    start, tmp_path, monkeypatch
):
    home = tmp_path / "Mein Spiel – テスト"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(home / "cache"))
    monkeypatch.chdir(home)
    done = start("new", "Spiel – テスト 2")
    assert done.returncode == 0, done.stderr
    monkeypatch.chdir(home / "Spiel – テスト 2")
    Path("line.json").write_text(json.dumps(SCHEDULE))
    done = start("run", "--schedule", "line.json", "-c", "hero", "-o", "テスト 1.csv")
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert "wrote テスト 1.csv" in done.stderr
    assert Path("テスト 1.csv").read_text().startswith("time_s,open,")
    told = start("validate").stdout
    assert told.count(": P") == 1, told
    assert "P406 not installed: speech (for english)" in told
    assert any((home / "cache").iterdir())


@pytest.mark.parametrize("version", ["3.12", "3.13", "3.14"])
def test_the_wheel_runs_on_other_pythons(version, dist, start, tmp_path):
    name = f"python{version}"
    kept = sorted(Path("~/.pyenv/versions").expanduser().glob(f"{version}.*/bin/{name}"))
    python = kept[-1] if kept else shutil.which(name)
    if not python or run(python, "-c", "import venv, ensurepip").returncode:
        pytest.skip(f"{name} is not on this machine")
    programs = installed_in(python, tmp_path / "environment", dist)
    Path("line.json").write_text(json.dumps(SCHEDULE))
    options = ("-l", "english", "-c", "facefx", "--schedule", "line.json", "-o")
    for command, written in ((programs, "a.csv"), (None, "b.csv")):
        arguments = ("run", *options, written)
        done = run(command / "lipsync-lang", *arguments) if command else start(*arguments)
        assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert Path("a.csv").read_text() == Path("b.csv").read_text()


def test_extras_that_are_missing_are_named(start):
    Path("line.json").write_text(json.dumps(SCHEDULE))
    done = start("run", "Hello", "-l", "english", "-c", "facefx", "-o", "a.csv")
    assert done.returncode == 2
    assert done.stderr.startswith("lipsync-lang: not installed: speech (for english)\n")
    assert 'pip install "lipsync-lang[speech]"' in done.stderr
    command = ("run", "-l", "english", "-c", "facefx", "--schedule", "line.json")
    done = start(*command, "-o", "a.csv", "--plot", "a.png")
    assert done.returncode == 2
    assert 'pip install "lipsync-lang[plot]"' in done.stderr
    assert done.stderr.startswith("lipsync-lang: not installed: plot (for a.png)\n")
    assert done.stderr.count("\n") == 2
    assert {path.name for path in Path().iterdir()} == {"line.json"}


@pytest.mark.parametrize("page", INSTALLED, ids=named)
def test_a_reader_can_follow_a_page(page, readers, outside):  # noqa: ARG001 the current folder
    # one process a page: to start the program for each command costs as much as the commands
    done = run(readers / "python", "-P", "-c", FOLLOW, TESTS, page)
    assert done.returncode == 0, done.stderr
