"""First runs: the screen without a command, and the project folder that `new` makes."""

import csv
import importlib.util
import json
import os
import re
import sys
import tomllib
import webbrowser
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
from lanes import full, swept
from shipped import LANGUAGES, LIBRARY, POSESETS

from lipsync_lang.base import extensions, extras
from lipsync_lang.commands import doctor, doctor_checks, parser
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.project import FILE, load_project
from lipsync_lang.packs.yaml import events
from lipsync_lang.production.builds.project_folder import project_files, starter
from lipsync_lang.render import fonts
from lipsync_lang.render.fonts import FoundFonts
from lipsync_lang.resolver.cache import CACHE_VARIABLE
from lipsync_lang.sound.speech import decoding
from lipsync_lang.sound.speech.speaking.speech_engines import ENGINES

FILES = {"README.md", FILE, "lines.csv", "characters/hero.yaml", ".gitignore"}

STAGE = "kind: language\nformat: 1\nname: stage\ntag: en-x-stage\nextends: english\n"

COMMENTED = re.compile(r"^# (\w+): (.+)$", re.MULTILINE)
"""A commented-out field of the project file."""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def without(monkeypatch, *modules):
    """Hide installed modules."""
    found = importlib.util.find_spec
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name in modules else found(name))


# Without a command


@pytest.mark.usefixtures("here")
def test_the_program_alone_says_what_to_do_next(cli):
    ended = cli()
    assert (ended.code, ended.err) == (0, "")
    assert len(ended.out.splitlines()) < 20
    for command in ("run", "new", "studio", "doctor", "--help"):
        assert f"lipsync-lang {command}" in ended.out


def test_the_sentence_of_the_screen_can_be_run(cli, here):
    pytest.importorskip("espeakng_loader", reason="a voice is an extra")
    (line,) = (line for line in cli().out.splitlines() if starter().text in line)
    _, _, options = line.partition(f'"{starter().text}" ')
    assert cli("run", starter().text, *options.split()).code == 0
    assert (here / "line.html").is_file()


@pytest.mark.usefixtures("here")
def test_a_missing_extra_is_named_with_its_installer(cli, monkeypatch):
    without(monkeypatch, "espeakng_loader")
    ended = cli()
    assert len(ended.out.splitlines()) < 20
    assert re.search(r'not installed: a voice .*install "lipsync-lang\[.*speech', ended.out)
    assert "[studio]" not in ended.out


def test_in_a_project_the_steps_are_its_own(cli, here, monkeypatch):
    assert cli("new", "game").code == 0
    monkeypatch.chdir(here / "game")
    told = cli().out
    assert f"in the project {FILE}" in told
    for step in ("build", "validate", f'run "{starter().text}"', "studio", "doctor"):
        assert f"lipsync-lang {step}" in told
    assert "lipsync-lang new" not in told
    Path(FILE).write_text("kind: project\nformat: 1\nlines: lines.csv\nlanguages: [english]\n")
    assert "lipsync-lang studio" in cli().out
    assert "lipsync-lang run" not in cli().out.replace("lipsync-lang run --help", "")
    Path(FILE).write_text("kind: project\nformat: 1\nfsp: 3\n")
    assert "find the faults of the project" in cli().out
    Path(FILE).write_text("kind: project\nformat: 1\n")
    assert "lipsync-lang build" not in cli().out


# A new project


@pytest.mark.parametrize("name", ["my-game", "my game", "Spiel für Zoë 口"])
def test_a_new_project_is_sound_and_builds(cli, here, monkeypatch, name):
    ended = cli("new", name)
    assert (ended.code, ended.out) == (0, "")
    assert {p.relative_to(here / name).as_posix() for p in walk(here / name)} == FILES
    assert f"wrote {Path(name, FILE)}" in ended.err
    assert [p.name for p in here.iterdir()] == [name]
    monkeypatch.chdir(here / name)
    assert cli("validate", "--no-tests").err == "0 faults, 0 warnings\n"
    if name == "my-game":
        ended = cli("build", "--tts", "none", "--workers", "1")
        assert ended.code == 0, ended.err
        assert "3 lines built" in ended.err
        assert len(list(Path("takes").glob("*.html"))) == 3
        assert set(Path(".gitignore").read_text().split()) >= {"takes/", "build/"}


def walk(folder):
    return [path for path in folder.rglob("*") if path.is_file()]


def test_a_new_project_opens_in_the_studio(cli, here, monkeypatch):
    pytest.importorskip("starlette", reason="the studio needs Starlette")
    from studio_calls import Caller

    from lipsync_lang.studio.project_lines import ProjectLines
    from lipsync_lang.studio.workshop import Workshop

    assert cli("new", "my-game").code == 0
    monkeypatch.chdir(here / "my-game")
    stated = load_project(Path(FILE)).model
    workshop = Workshop(Path.cwd(), engine="none", script=ProjectLines(Path.cwd() / FILE))
    workshop.open_restored(stated.language, stated.character)
    caller = Caller(workshop)
    state = caller.api("state").json
    assert (state["language"], state["character"]) == (stated.language, stated.character)
    with Path("lines.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["text"] for row in rows] == list(starter().lines)
    found = caller.api("script").json["lines"]
    assert [(one["name"], one["text"]) for one in found] == [(r["id"], r["text"]) for r in rows]
    for row in rows:
        assert caller.post("script", {"name": row["id"]}).status == 200


@pytest.mark.parametrize("language", swept(LANGUAGES, quick=["japanese", "arabic"]))
def test_a_project_of_any_language_has_lines_to_read(language, tmp_path):
    made = project_files("game", LIBRARY, language, None)
    rows = list(csv.DictReader(made["lines.csv"].splitlines()))
    assert 1 <= len(rows) <= 3
    assert all(row["text"] for row in rows)
    known = {test.text for test in LIBRARY.language(language).model.tests}
    assert {row["text"] for row in rows} <= known | set(starter().lines)
    assert rows[0]["text"] in (starter().lines if language == starter().language else known)
    (tmp_path / FILE).write_text(made[FILE], encoding="utf-8")
    assert load_project(tmp_path / FILE).model.language == language


@pytest.mark.parametrize("poseset", swept(POSESETS, quick=["crab"]))
def test_a_project_of_any_pose_set_is_built(cli, here, monkeypatch, poseset):
    assert cli("new", "game", "-c", poseset).code == 0
    monkeypatch.chdir(here / "game")
    assert f"poseset: {poseset}" in Path("characters/hero.yaml").read_text()
    ended = cli("build", "--tts", "none", "--workers", "1")
    assert ended.code == 0, ended.err


def test_lines_are_the_longest_examples_and_a_command_shows_a_plain_one(tmp_path):
    (tmp_path / "languages").mkdir()
    texts = ["yes", '"no" to all of it', "yes and no", "all of `it` now", '"no" to all of it']
    tests = "".join(f"  - {{text: {json.dumps(text)}, phonemes: [l]}}\n" for text in texts)
    (tmp_path / "languages/stage.yaml").write_text(f"{STAGE}tests:\n{tests}")
    made = project_files("game", Library(tmp_path, project=None), "stage", None)
    rows = list(csv.DictReader(made["lines.csv"].splitlines()))
    assert [row["text"] for row in rows] == texts[1:4]
    assert 'lipsync-lang run "yes and no"' in made["README.md"]


def test_a_project_of_other_packs_finds_them_again(cli, here, monkeypatch):
    (here / "more packs/characters").mkdir(parents=True)
    bob = here / "more packs/characters/bob.yaml"
    bob.write_text("kind: character\nformat: 1\nname: bob\nposeset: crab\n", encoding="utf-8")
    assert cli("new", "game", "-c", "bob", "--path", "more packs").code == 0
    monkeypatch.chdir(here / "game")
    assert load_project(Path(FILE)).model.paths == ("../more packs",)
    ended = cli("build", "--tts", "none", "--workers", "1")
    assert ended.code == 0, ended.err


@full
def test_an_installed_character_needs_no_file(tmp_path):
    folder = tmp_path / "characters"
    folder.mkdir()
    (folder / "bob.yaml").write_text("kind: character\nformat: 1\nname: bob\nposeset: crab\n")
    made = project_files("game", Library(tmp_path, project=None), None, "bob")
    assert set(made) == FILES - {"characters/hero.yaml"}
    assert "character: bob" in made[FILE]
    assert "hero.yaml" not in made["README.md"]


def test_every_field_of_a_project_is_in_the_new_one_and_sound_when_it_is_on(tmp_path):
    text = project_files("game", LIBRARY, None, None)[FILE]
    on = set(re.findall(r"^(\w+):", text, re.MULTILINE))
    off = {name for name, _ in COMMENTED.findall(text)}
    assert on | off == set(Project.model_fields)
    assert not on & off
    path = tmp_path / FILE
    for field in sorted(off):
        path.write_text(re.sub(rf"^# {field}:", f"{field}:", text, flags=re.MULTILINE), "utf-8")
        assert field in load_project(path).model.model_fields_set


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["taken"], "taken: is there already; choose another name"),
        (["file.txt"], "file.txt: is there already; choose another name"),
        (["link"], "link: is there already; choose another name"),
        (["../out"], "has a '/'"),
        ([".."], "begins with a dot"),
        (["/out"], "has a '/'"),
        (["con"], "the name of a device on Windows"),
        ([""], "is empty"),
        (["game", "-l", "englsh"], "did you mean 'english'?"),
        (["game", "-c", "crabb"], "did you mean 'crab'?"),
    ],
)
def test_a_project_that_cannot_be_made_is_refused_and_nothing_is_left(cli, here, arguments, told):
    (here / "taken").mkdir()
    (here / "file.txt").write_text("mine")
    (here / "link").symlink_to("nowhere")
    ended = cli("new", *arguments)
    assert ended.code != 0
    assert told in ended.err
    assert sorted(path.name for path in here.iterdir()) == ["file.txt", "link", "taken"]
    assert not list((here / "taken").iterdir())


def test_a_project_is_made_whole_or_not_at_all(cli, here, monkeypatch):
    def fail(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "replace", fail)
    ended = cli("new", "game")
    assert ended.code == 2
    assert "game: cannot be written: Permission denied; change to another" in ended.err
    assert not list(here.iterdir())


# Extras


def test_every_extra_is_listed_with_what_it_is_for(root):
    stated = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    wanted = set(stated["optional-dependencies"]) - {"all", "dev", "docs"}
    assert {one.name for one in extras.extras()} == wanted
    for one in extras.extras():
        assert one.purpose, one.name
        assert one.used_by, one.name
        assert one.modules, one.name


def test_every_extra_that_a_message_names_is_one(root):
    known = {one.name for one in extras.extras()}
    text = "".join(p.read_text("utf-8") for p in sorted((root / "lipsync_lang").rglob("*.py")))
    named = set(re.findall(r"install_line\(['\"](\w+)['\"]\)", text))
    assert named
    assert named <= known


@pytest.mark.parametrize(
    ("file", "content", "line"),
    [
        ("pyvenv.cfg", "home = /usr", "{python} -m pip install"),
        ("pyvenv.cfg", "home = /usr\nuv = 0.5.1\n", "uv pip install"),
        ("pipx_metadata.json", "{}", "pipx install --force"),
        ("uv-receipt.toml", "", "uv tool install"),
    ],
)
def test_the_installer_of_the_environment_is_named(tmp_path, monkeypatch, file, content, line):
    (tmp_path / file).write_text(content)
    monkeypatch.setattr(extras.sys, "prefix", str(tmp_path))
    monkeypatch.setattr(extras.sys, "executable", str(tmp_path / "bin/python"))
    monkeypatch.delenv("VIRTUAL_ENV", raising=False)
    told = extras.install_line("plot")
    assert told.startswith(line.format(python=tmp_path / "bin/python"))
    assert re.search(r'"lipsync-lang\[[\w,]*\bplot\b[\w,]*\]"$', told)
    monkeypatch.setenv("VIRTUAL_ENV", str(tmp_path))
    if "pip install" in line and "uv" not in line:
        assert extras.install_line("plot") == 'pip install "lipsync-lang[plot]"'
    monkeypatch.setenv("VIRTUAL_ENV", str(tmp_path / "another"))
    assert extras.install_line("plot") == told


def test_the_line_runs_in_this_folder_and_with_spaces(here, monkeypatch):
    monkeypatch.setattr(extras.sys, "prefix", str(here))
    monkeypatch.delenv("VIRTUAL_ENV", raising=False)
    monkeypatch.setattr(extras.sys, "executable", str(here / ".venv/bin/python"))
    assert extras.install_line("plot").startswith(f"{Path('.venv/bin/python')} -m pip")
    monkeypatch.setattr(extras.sys, "executable", "/my programs/python")
    assert extras.install_line("plot").startswith('"/my programs/python" -m pip')


def test_a_module_without_a_specification_counts_as_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "half_made", ModuleType("half_made"))
    assert extras.Extra("x", "", "", ("half_made", "json")).missing() == ["half_made"]


@pytest.mark.parametrize(
    ("file", "content", "line"),
    [
        ("pyvenv.cfg", "home = /usr", "-m pip install polars"),
        ("pyvenv.cfg", "home = /usr\nuv = 0.5.1\n", "uv pip install polars"),
        ("pipx_metadata.json", "{}", "pipx inject lipsync-lang polars"),
        ("uv-receipt.toml", "", 'uv tool install "lipsync-lang[tables]" --with polars'),
    ],
)
def test_a_package_of_others_is_installed_by_the_same_installer(
    tmp_path, monkeypatch, file, content, line
):
    (tmp_path / file).write_text(content)
    monkeypatch.setattr(extras.sys, "prefix", str(tmp_path))
    without(monkeypatch, *(m for one in extras.extras() for m in one.modules if m != "openpyxl"))
    assert extras.package_line("polars").endswith(line)


def test_no_message_names_an_installer_of_its_own(root):
    text = {p: p.read_text("utf-8") for p in sorted((root / "lipsync_lang").rglob("*.py"))}
    told = {path.name for path, one in text.items() if re.search(r"pip install \W*\w", one)}
    assert told <= {"dask_cluster.py"}, "extras.install_line knows the installer"


def test_extras_that_are_there_are_kept_by_an_installer_that_starts_anew(tmp_path, monkeypatch):
    (tmp_path / "uv-receipt.toml").touch()
    monkeypatch.setattr(extras.sys, "prefix", str(tmp_path))
    without(monkeypatch, *(m for one in extras.extras() for m in one.modules if m != "openpyxl"))
    assert extras.install_line("plot") == 'uv tool install "lipsync-lang[plot,tables]"'


def test_the_screen_lists_extras_that_are_known():
    assert set(parser.SHOWN_IN_NEXT_STEPS) <= {one.name for one in extras.extras()}


# Doctor


def states(ended):
    return {one["part"]: one["state"] for one in json.loads(ended.out)}


@pytest.fixture
def healthy(here, monkeypatch):
    """Checks that start no process."""
    monkeypatch.setattr(
        doctor_checks, "_extra", lambda one: doctor_checks.CheckedPart(one.name, "ok", "")
    )
    return here


def test_the_doctor_names_every_part(cli, healthy):
    assert cli("new", "game").code == 0
    ended = cli("doctor", "--json")
    found = states(ended)
    assert ended.code == int("broken" in found.values())
    assert {"Python", "packs", "project", "cache", "terminal"} <= set(found)
    assert {"mfa", "plug-in mfa"} & set(found), "its own check runs, or its loss is told"
    assert {one.name for one in extras.extras()} <= set(found)
    assert list(healthy.iterdir()) == [healthy / "game"]


@pytest.mark.usefixtures("healthy")
def test_a_broken_project_fails_the_check(cli):
    Path(FILE).write_text("kind: project\nformat: 1\nfsp: 3\n")
    ended = cli("doctor")
    assert ended.code == 1
    assert re.search(r"^broken +project .*fsp", ended.out, re.MULTILINE)


def test_a_removed_plug_in_is_named_with_what_it_costs(cli, healthy, monkeypatch):
    info = healthy / "site" / "lipsync_lang-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Name: lipsync-lang\nVersion: 1.0\n")
    gone = "lipsync_lang.plugins.gone"
    (info / "entry_points.txt").write_text(
        f"[lipsync_lang.commands]\nbank-sing = {gone}.sing_command\n"
        "run = lipsync_lang.commands.run\n"
        f"[lipsync_lang.aligners]\nchoir = {gone}.choir\n"
        "[lipsync_lang.doctor_checks]\nfar = lipsync_lang.away.far.far_check\n"
    )
    monkeypatch.syspath_prepend(healthy / "site")
    monkeypatch.setattr(doctor_checks, "MORE_CHECKS", {})
    ended = cli("doctor", "--json")
    found = {one["part"]: one for one in json.loads(ended.out) if "removed" in one["told"]}
    assert {name: one["told"] for name, one in found.items()} == {
        "plug-in far": "its folder was removed: no doctor check 'far'; install lipsync-lang again",
        "plug-in gone": "its folder was removed: no aligner 'choir', no command 'bank sing'; "
        "install lipsync-lang again",
    }
    assert {one["state"] for one in found.values()} == {"missing"}


@pytest.mark.usefixtures("healthy")
def test_a_check_that_fails_is_a_broken_part(cli, monkeypatch):
    def _odd():
        raise ZeroDivisionError("no reason")
        yield

    monkeypatch.setattr(doctor_checks, "CHECKS", (_odd,))
    monkeypatch.setattr(doctor_checks, "MORE_CHECKS", {})
    ended = cli("doctor")
    assert ended.code == 1
    assert "broken  odd  ZeroDivisionError: no reason" in ended.out


@pytest.mark.parametrize(
    ("module", "state", "told"),
    [
        ("json", "ok", "reads"),
        ("no_such_module_here", "missing", "install"),
        ("antigravity_broken", "broken", "install it again"),
    ],
)
def test_an_extra_is_imported_in_a_process_of_its_own(tmp_path, monkeypatch, module, state, told):
    (tmp_path / "antigravity_broken.py").write_text("raise OSError('no library')\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    found = doctor_checks._extra(extras.Extra("tables", "reads", "build", (module,)))  # noqa: SLF001
    assert (found.state, told in found.told) == (state, True)


def test_a_part_that_the_system_lacks_is_no_fault_of_the_installation(monkeypatch):
    monkeypatch.setattr(doctor_checks, "fault_of", lambda _: "OSError: no library")
    extra = extras.Extra("tables", "reads", "build", ("json",), system="the library Z")
    found = doctor_checks._extra(extra)  # noqa: SLF001
    assert (found.state, found.told) == ("missing", "reads; your system lacks the library Z")


def test_an_import_that_hangs_is_given_up(tmp_path, monkeypatch):
    (tmp_path / "hanging_module.py").write_text("import time\ntime.sleep(60)\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(doctor_checks, "IMPORT_SECONDS", 0.3)
    extra = extras.Extra("tables", "reads", "build", ("hanging_module",))
    assert doctor_checks._extra(extra).state == "broken"  # noqa: SLF001


CHECKS = {check.__name__.strip("_"): check for check in doctor_checks.CHECKS}


def one(name):
    """Return the only part of a check."""
    (found,) = CHECKS[name]()
    return found.state, found.told


@pytest.mark.usefixtures("here")
def test_the_voices_are_those_of_the_project(monkeypatch):
    pytest.importorskip("espeakng_loader", reason="a voice is an extra")
    Path("languages").mkdir()
    Path("languages/stage.yaml").write_text(f"{STAGE}g2p: {{engine: espeak, voice: nowhere}}\n")
    assert [found.part for found in doctor_checks.voices()] == [f"voice of {starter().language}"]
    Path(FILE).write_text("kind: project\nformat: 1\nlanguages: {finnish: fi}\nlanguage: stage\n")
    found = {one.part: one for one in doctor_checks.voices()}
    assert {part: one.state for part, one in found.items()} == {
        "voice of finnish": "ok",
        "voice of stage": "broken",
    }
    assert "no voice 'nowhere'" in found["voice of stage"].told
    without(monkeypatch, "espeakng_loader")
    assert not list(doctor_checks.voices())


def test_a_browser_is_found_or_named(monkeypatch):
    monkeypatch.setattr(webbrowser, "get", lambda: None)
    assert one("browser")[0] == "ok"

    def none():
        raise webbrowser.Error

    monkeypatch.setattr(webbrowser, "get", none)
    assert one("browser")[0] == "missing"


def test_fonts_to_install_are_named(monkeypatch):
    pytest.importorskip("matplotlib", reason="plots are an extra")
    for missing, state, told in (("", "ok", "ʃ"), ("क", "missing", "Noto Sans Devanagari: ")):
        found = FoundFonts((), frozenset(missing))
        monkeypatch.setattr(fonts, "fonts_for", lambda _, found=found: found)
        assert one("fonts")[0] == state
        assert told in one("fonts")[1]
    without(monkeypatch, "matplotlib")
    assert not list(CHECKS["fonts"]())


def test_the_cache_can_be_written_and_has_room(here, monkeypatch):
    (here / "file").touch()
    for named, state, told in (
        ("new/cache", "ok", "GB free"),
        ("off", "missing", "is off by"),
        ("file", "broken", f"cannot be written; name another folder in {CACHE_VARIABLE}"),
    ):
        monkeypatch.setenv(CACHE_VARIABLE, named)
        assert one("cache")[0] == state
        assert told in one("cache")[1]
    monkeypatch.setenv(CACHE_VARIABLE, "new/cache")
    few = SimpleNamespace(free=doctor_checks.LEAST_FREE_BYTES - 1)
    monkeypatch.setattr(doctor_checks.shutil, "disk_usage", lambda _: few)
    assert one("cache")[0] == "broken"
    assert "has 200 MB left" in one("cache")[1]


@pytest.mark.parametrize(("encoding", "state"), [("utf-8", "ok"), ("cp1252", "missing")])
def test_a_terminal_without_unicode_is_told(monkeypatch, encoding, state):
    monkeypatch.setattr(doctor.sys, "stdout", SimpleNamespace(encoding=encoding))
    found = one("terminal")
    assert (found[0], "PYTHONUTF8=1" in found[1]) == (state, state == "missing")


def test_modules_of_the_current_folder_are_not_imported(here):
    (here / "odd_local_module.py").write_text("")
    assert "odd_local_module" in doctor_checks.fault_of("import odd_local_module")


def test_the_faults_of_packs_are_counted_with_the_command_that_lists_them(cli, healthy):
    for name, tag in (("one", "en"), ("two", "en-GB")):
        file = healthy / "languages" / f"{name}.yaml"
        file.parent.mkdir(exist_ok=True)
        file.write_text(f"kind: language\nformat: 1\nname: {name}\ntag: {tag}\nodd: 1\n")
    ended = cli("doctor")
    (told,) = re.findall(r"^broken +packs +(.*)$", ended.out, re.MULTILINE)
    counted = re.match(r"(\d+) faults? \((.*?)\), ", told)
    codes = dict(reversed(one.split()) for one in counted[2].split(", "))
    assert int(counted[1]) == sum(map(int, codes.values())) >= 2
    assert told.endswith("list them: lipsync-lang validate --no-tests")
    listed = cli("validate", "--no-tests")
    found = re.findall(r": (P\d+) (?!warning)", listed.out)
    assert {code: str(found.count(code)) for code in found} == codes


@pytest.fixture
def plugged(tmp_path, monkeypatch):
    """Install a plug-in with a module and a folder of packs."""

    def put(text, packs="odd_packs"):
        site = tmp_path / "site"
        info = site / "odd-1.5.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: odd\nVersion: 1.5\n")
        (info / "entry_points.txt").write_text(
            f"[lipsync_lang.writers]\nodd = odd_plug_in\n[lipsync_lang.packs]\nodd = {packs}\n"
        )
        (site / "odd_plug_in.py").write_text(text)
        (site / "odd_packs").mkdir()
        (site / "odd_packs/__init__.py").write_text("raise AssertionError('packs are data')")
        monkeypatch.syspath_prepend(site)
        found = os.environ.get("PYTHONPATH", "")
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(site), found])))
        extensions._declared.cache_clear()  # noqa: SLF001 the folder is new
        return {one.part: one for one in CHECKS["plug_ins"]()}["plug-in odd"]

    yield put
    extensions._declared.cache_clear()  # noqa: SLF001


GOOD = "from lipsync_lang.animations.animation_writers import writer\n"
TAKEN = """from lipsync_lang.sound.speech.speaking.speech_engines import speech_engine
@speech_engine("espeak")
class Mine:
    pass
"""


@pytest.mark.parametrize(
    ("text", "packs", "state", "told"),
    [
        (GOOD, "odd_packs", "ok", "1.5 with packs, writers"),
        ("print('hello')", "odd_packs", "ok", "1.5"),
        ("raise OSError('no library')", "odd_packs", "broken", "OSError: no library"),
        ("raise SystemExit(0)", "odd_packs", "broken", "SystemExit"),
        (TAKEN, "odd_packs", "broken", "espeak' of odd is left out"),
        (GOOD, "no_packs", "broken", "no folder no_packs"),
    ],
)
def test_plug_ins_are_named_with_what_they_bring(plugged, text, packs, state, told):
    found = plugged(text, packs)
    assert (found.state, told in found.told) == (state, True), found


@pytest.mark.parametrize(("text", "state"), [("echo ffmpeg version 7", "ok"), ("exit 3", "broken")])
@pytest.mark.skipif(os.name != "posix", reason="the program here is a script of a shell")
def test_an_ffmpeg_that_does_not_run_is_broken(monkeypatch, tmp_path, text, state):
    program = tmp_path / "ffmpeg"
    program.write_text(f"#!/bin/sh\n{text}\n")
    program.chmod(0o755)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    (found,) = doctor_checks.ffmpeg()
    assert (found.state, str(program) in found.told) == (state, True)


def test_no_ffmpeg_names_the_extra(monkeypatch):
    monkeypatch.setattr(decoding, "find_ffmpeg", lambda: None)
    (found,) = doctor_checks.ffmpeg()
    assert found.state == "missing"
    assert re.search(r"install .*lipsync-lang\[.*video", found.told)


def test_the_voice_of_a_language_of_another_engine_is_checked(healthy, monkeypatch):
    (healthy / "languages").mkdir()
    (healthy / "languages/odd.yaml").write_text(
        "kind: language\nformat: 1\nname: odd\ntag: x-odd\n"
        "notations: {letters: {m: bmp, a: aa}}\ntts: {engine: festival, voice: kal_diphone}\n"
    )
    Path(FILE).write_text("kind: project\nformat: 1\nlanguage: odd\n")
    engine = SimpleNamespace(voices=lambda: {"kal_diphone": "kal"})
    monkeypatch.setitem(ENGINES.known, "festival", engine)
    assert [(one.part, one.state) for one in doctor_checks.voices()] == [("voice of odd", "ok")]
    engine.voices = dict
    assert [one.state for one in doctor_checks.voices()] == ["broken"]


@pytest.mark.parametrize(("there", "told"), [(True, "libyaml"), (False, "13 times slower")])
def test_the_doctor_says_how_packs_are_parsed(monkeypatch, there, told):
    monkeypatch.setattr(events, "parser_in_c", lambda: there)
    (part,) = doctor_checks._yaml()  # noqa: SLF001
    assert told in part.told
    assert (part.state == "ok") == there
