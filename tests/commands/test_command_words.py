"""Verbosity of the command line, completion in shells, and names in any case."""

import json
import logging
import shutil
import subprocess
import sys
import warnings

import pytest
from lanes import full, needs_plug_ins

import lipsync_lang as ll
from lipsync_lang.base.extensions import PluginWarning
from lipsync_lang.cli import saying
from lipsync_lang.commands.parser import parser
from lipsync_lang.commands.registry import leaves
from lipsync_lang.commands.shared_options import option_sets

SAYING = {path: made for path, made in leaves(parser()) if path}
LINE = '[{"label": "HH", "start": 0, "end": 0.1}, {"label": "AY", "start": 0.1, "end": 0.3}]'
PAIR = ("-l", "english", "-c", "facefx")


@pytest.fixture
def line(tmp_path, monkeypatch):
    """A file of timed phonemes in an empty folder."""
    (tmp_path / "line.json").write_text(LINE)
    monkeypatch.chdir(tmp_path)
    return "line.json"


@pytest.mark.parametrize("path", SAYING, ids=" ".join)
def test_every_command_can_be_quiet_or_tell_more(path):
    assert {"--quiet", "--verbose"} <= SAYING[path]._option_string_actions.keys()  # noqa: SLF001


READ_FORMATS = {("live",): "the format of the samples that it reads; it prints JSON"}
"""Commands whose `--format` is that of their input, with the reason."""


@pytest.mark.parametrize("path", SAYING, ids=" ".join)
def test_what_has_a_format_has_json(path):
    known = SAYING[path]._option_string_actions  # noqa: SLF001
    assert "--format" in known or path not in READ_FORMATS
    if "--format" in known and path not in READ_FORMATS:
        assert "--json" in known
        assert known["--json"].dest == "format"


def test_the_log_is_silent_unless_it_is_asked_for(cli, line, monkeypatch):
    monkeypatch.delenv("LIPSYNC_LANG_LOG", raising=False)
    usual = cli("run", "--schedule", line, *PAIR)
    assert "lipsync_lang." not in usual.err
    told = cli("run", "--schedule", line, *PAIR, "-v")
    assert "lipsync_lang.schedules.timing_readers: line.json is read as json" in told.err
    assert "lipsync_lang.resolver.cache: english on facefx:" in told.err
    assert told.err.endswith(usual.err)
    monkeypatch.setenv("LIPSYNC_LANG_LOG", "info")
    assert "is read as json" in cli("run", "--schedule", line, *PAIR).err
    assert not logging.getLogger("lipsync_lang").handlers


def test_the_log_says_once_whether_a_pair_is_cached(cli, tmp_path, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path))
    for told in ("to be compiled", "cached"):
        assert cli("resolve", *PAIR, "-v").err.count(f"english on facefx: {told}") == 1


def test_an_unknown_level_of_the_log_is_a_message(cli, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_LOG", "all")
    ended = cli("formats")
    assert ended.code == 2
    assert ended.err == (
        "lipsync-lang: LIPSYNC_LANG_LOG=all: set it to one of debug, info, warning, or unset it\n"
    )


def test_quiet_leaves_data_and_errors(cli, line):
    assert cli("run", "--schedule", line, *PAIR, "-q", "-o", "line.csv") == (0, "", "")
    assert cli("formats", "--quiet").out == cli("formats").out
    ended = cli("run", "--schedule", "gone.json", *PAIR, "-q")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err.startswith("lipsync-lang: gone.json: ")


def test_quiet_and_verbose_exclude_each_other(cli):
    assert "not allowed with argument -q" in cli("formats", "-q", "-v").err


def test_a_plug_ins_warning_is_a_line(capsys):
    options = parser().parse_args(["formats"])
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        usual = []
        warnings.showwarning = lambda message, *_: usual.append(str(message))
        with saying(options):
            warnings.warn("paint is left out", PluginWarning, stacklevel=1)
            warnings.warn("other", UserWarning, stacklevel=1)
    assert (usual, capsys.readouterr().err) == (["other"], "paint is left out\n")


def test_json_is_the_same_as_the_form(cli, line):
    for command in (
        ("check", "--schedule", line, *PAIR),
        ("coverage", line, *PAIR),
    ):
        assert cli(*command, "--json").out == cli(*command, "--format", "json").out
        assert json.loads(cli(*command, "--json").out)
    assert json.loads(cli("schema", "--json").out) == cli("schema").out.split()


def test_an_unknown_form_of_a_coverage_tells_the_nearest(cli, line):
    ended = cli("coverage", line, *PAIR, "--format", "jsn")
    assert "unknown coverage format 'jsn'; did you mean 'json'?" in ended.err


@pytest.mark.parametrize("name", ["facefx", "FaceFX", "FACEFX"])
def test_faces_are_found_in_any_case(name):
    performer = ll.resolve("English", name)
    assert performer.character == "facefx"


@full
def test_a_name_as_it_is_spelled_comes_before_one_in_other_letters(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    for name in ("ann", "Ann"):
        text = f"kind: character\nformat: 1\nname: {name}\nposeset: facefx\n"
        (tmp_path / f"characters/{name}.yaml").write_text(text)
    for name in ("ann", "Ann"):
        assert ll.resolve("english", name).character == name
    assert ll.resolve("english", "ANN").character in ("ann", "Ann")


def test_poses_are_found_in_any_case():
    schedule = ll.Schedule(("HH", "AY"), [0, 0.1, 0.3])
    animation = ll.resolve("english", "facefx").perform(schedule)
    assert (animation["OPEN"] == animation["open"]).all()
    with pytest.raises(ll.LipsyncError, match="unknown pose 'opne'; did you mean 'open'"):
        animation["opne"]


def test_regions_are_found_in_any_case(cli, line):
    usual = cli("explain", "--schedule", line, *PAIR, "--at", "0.2", "--dial", "jaw:0.5")
    assert usual.code == 0
    assert cli("explain", "--schedule", line, *PAIR, "--at", "0.2", "--dial", "JAW:0.5") == usual


COMPLETED = [
    ("run -l finn", "finnish"),
    ("resolve -c face", "facefx"),
    ("transc", "transcribe"),
    ("bank dra", "draft"),
    ("run --key", "--keys"),
    pytest.param("study rep", "report", marks=needs_plug_ins),
    pytest.param("study report . /de", "/dev", marks=needs_plug_ins),
]


SHELL_PROGRAMS = {
    "bash": (
        "bash",
        """source {script}; COMP_WORDS=({typed}); COMP_CWORD={last}; COMP_LINE='{typed}'
        COMP_POINT=${{#COMP_LINE}}; _shtab_lipsync_lang lipsync-lang
        printf '%s\\n' ${{COMPREPLY[@]}}""",
    ),
    "fish": ("fish", "source {script}; complete -C '{typed}'"),
    "powershell": (
        "pwsh",
        ". {script}; (TabExpansion2 '{typed}' {length}).CompletionMatches.CompletionText",
    ),
}
"""Programs of shells, with the line that prints the completions of what is typed."""


@pytest.mark.parametrize("shell", SHELL_PROGRAMS)
@pytest.mark.parametrize(("typed", "wanted"), COMPLETED)
def test_a_shell_completes(cli, shell, typed, wanted, tmp_path):
    pytest.importorskip("shtab", reason="the completion extra is not installed")
    ended = cli("completion", shell)
    assert ended.code == 0
    # where the shell is missing, the script has the word and closed braces at least
    assert wanted in ended.out + "/dev"
    assert ended.out.count("{") == ended.out.count("}")
    program, asked = SHELL_PROGRAMS[shell]
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed")
    script = tmp_path / f"script.{'ps1' if program == 'pwsh' else shell}"
    script.write_text(ended.out)
    words = f"lipsync-lang {typed}"
    line = asked.format(script=script, typed=words, length=len(words), last=len(words.split()) - 1)
    done = subprocess.run([program, "-c", line], capture_output=True, encoding="utf-8", check=False)
    found = {line.partition("\t")[0].rstrip("/") for line in done.stdout.splitlines()}
    assert wanted in found, done


@pytest.mark.parametrize("shell", option_sets()["completion"][0][2]["choices"])
def test_every_shell_has_a_script_and_a_place_for_it(cli, shell, root):
    pytest.importorskip("shtab", reason="the completion extra is not installed")
    assert "lipsync-lang" in cli("completion", shell).out
    page = (root / "docs" / "how-to" / "set-up-your-shell.md").read_text("utf-8")
    assert f"`lipsync-lang completion {shell} > " in page


def test_a_missing_shtab_names_the_extra(cli, monkeypatch):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert 'pip install "lipsync-lang[completion]"' in cli("completion", "zsh").err


def test_a_mistyped_command_is_suggested(cli):
    ended = cli("runn")
    assert ended.code == 2
    assert "unknown command 'runn': did you mean 'run'?" in ended.err


def test_a_file_is_not_spoken_as_its_name(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.txt").write_text("Hello.", "utf-8")
    ended = cli("run", "script.txt", "-l", "english", "-c", "facefx")
    assert ended.code == 2
    assert "script.txt: is a file" in ended.err
