"""Windows and macOS: no calls that need POSIX, and commands with Windows imitated.

Nothing here runs on Windows or macOS. A sweep over the source finds calls that they lack, and
`as_windows.py` runs commands with as much of Windows as this system can imitate.
"""

import ast
import ctypes
import io
import json
import ntpath
import os
import subprocess
import sys
from pathlib import Path, PureWindowsPath

import as_windows
import pytest
from build_project import Game
from lanes import full
from syntax_trees import modules, walked
from test_house import wing

import lipsync_lang as ll
from lipsync_lang.base.files import atomic, child_processes, temporary, writing
from lipsync_lang.base.files.locking import claim
from lipsync_lang.base.files.quoting import shell_command
from lipsync_lang.cli import main
from lipsync_lang.production.builds import output_paths

PACKAGE = Path(ll.__file__).parent
SCRIPT = Path(as_windows.__file__)

# What the source may say


POSIX_ONLY = {
    name: module.__name__ for module, names in as_windows.MISSING.items() for name in names.split()
}

ALLOWED = {
    ("base/files/locking.py", "fcntl"): "where it is missing, msvcrt locks",
    ("base/files/temporary.py", "uname"): "asked for first; COMPUTERNAME otherwise",
    ("base/files/targets.py", "effective_ids"): "asked for first",
    ("base/files/writing.py", "chown"): "asked for first",
    ("sound/speech/hearing/sphinx/sphinx_worker.py", "resource"): "not on Windows, without a limit",
    ("plugins/whisper/whisper_worker.py", "resource"): "not on Windows, without a limit",
    ("commands/local_server.py", "getuid"): "only where `os.name` is posix",
    ("base/files/child_processes.py", "SIG_BLOCK"): "after `pthread_sigmask` was asked for",
    ("base/files/child_processes.py", "SIG_SETMASK"): "after `pthread_sigmask` was asked for",
    (
        "text/phonology/espeak/espeak_worker.py",
        "fork",
    ): "a task that is asked for only where it can be",
    ("text/phonology/espeak/espeak_worker.py", "setitimer"): "in a forked process",
    ("text/phonology/espeak/espeak_worker.py", "ITIMER_REAL"): "in a forked process",
    ("text/phonology/espeak/espeak_worker.py", "set_blocking"): "in a forked process",
    (
        "text/phonology/espeak/espeak_stream.py",
        "selectors",
    ): "of pipes, only where a process can fork",
    ("text/phonology/espeak/espeak_stream.py", "register_at_fork"): "where a process can fork",
    ("text/phonology/espeak/espeak_stream.py", "fcntl"): "its absence keeps the usual pipe",
    ("plugins/mfa/mfa_command.py", "killpg"): "not on Windows, which has taskkill",
    ("plugins/mfa/mfa_command.py", "SIGKILL"): "not on Windows, which has taskkill",
    ("plugins/study/study_clips.py", "sched_getaffinity"): "asked for first",
}
"""Reason for an exception by (module, name); obsolete entries must be removed."""

ALONE = {"fcntl", "selectors", "select", *as_windows.ABSENT}
"""Modules whose imports need an entry."""


def posix_names(tree):
    """Yield the names in a module that Windows lacks."""
    for node in walked(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if POSIX_ONLY.get(node.attr) == node.value.id:
                yield node.attr
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in ALONE)
        elif isinstance(node, ast.ImportFrom):
            yield from (a.name for a in node.names if POSIX_ONLY.get(a.name) == node.module)
            yield from [node.module] if node.module in ALONE else []
        elif isinstance(node, ast.keyword) and node.arg in {"effective_ids", "preexec_fn"}:
            yield node.arg


def test_no_module_uses_what_windows_lacks_without_a_way_around():
    found = {(name, used) for name, tree in modules().items() for used in posix_names(tree)}
    there = {name for name in ALLOWED if name[0] in modules() or wing(name[0]) != "plugins"}
    assert found == there, "the wing of plug-ins alone can be removed"


def calls(tree, *names):
    """Yield the calls of functions and methods by name."""
    for node in walked(tree):
        if isinstance(node, ast.Call):
            called = getattr(node.func, "attr", None) or getattr(node.func, "id", None)
            if called in names:
                yield called, node, {word.arg: word.value for word in node.keywords}


def constant(node):
    return node.value if isinstance(node, ast.Constant) else None


def in_text_mode(called, node, words):
    """Return True if a call reads or writes text without a stated encoding."""
    if called in {"read_text", "write_text"}:
        return "encoding" not in words and len(node.args) < (1 if called == "read_text" else 2)
    if called in {"run", "Popen", "check_output"}:
        return bool(words.keys() & {"text", "universal_newlines"}) and "encoding" not in words
    mode = words.get("mode") or node.args[0 if called == "open" else 1 :][:1]
    mode = constant(mode[0] if isinstance(mode, list) and mode else mode)
    return isinstance(mode, str) and "b" not in mode and "encoding" not in words


def test_every_text_states_its_encoding():
    names = ("read_text", "write_text", "run", "Popen", "check_output", "fdopen", "open")
    loose = [
        f"{name}:{node.lineno}"
        for name, tree in modules().items()
        for called, node, words in calls(tree, *names)
        if in_text_mode(called, node, words)
    ]
    assert not loose


def test_every_writer_of_text_states_how_lines_end():
    found = [
        (name, node, words)
        for name, tree in modules().items()
        for _, node, words in calls(tree, "TextIOWrapper", "TemporaryFile")
        if words or len(node.args) > 1
    ]
    assert found, "a sweep over nothing passes"
    assert not [f"{name}:{node.lineno}" for name, node, words in found if "newline" not in words]


def test_every_rename_tries_again_while_a_scanner_reads():
    found = [
        f"{name}:{node.lineno}"
        for name, tree in modules().items()
        for called, node, words in calls(tree, "rename", "replace", "renames", "move")
        if ast.unparse(node.func) in {"os.rename", "os.replace", "shutil.move"}
        or (
            called in {"rename", "replace"}
            and len(node.args) == 1
            and not words
            and isinstance(node.func, ast.Attribute)  # `replace` alone is that of dataclasses
        )
    ]
    elsewhere = [one for one in found if not one.startswith("base/files/writing.py")]
    assert found, "a sweep over nothing passes"
    assert elsewhere == []


# Single pieces


def test_commands_are_quoted_as_the_shell_reads_them(monkeypatch):
    parts = ["ffmpeg", "-i", "my voice.m4a", "it's.wav"]
    assert shell_command(parts) == "ffmpeg -i 'my voice.m4a' 'it'\"'\"'s.wav'"
    monkeypatch.setattr(sys, "platform", "win32")
    assert shell_command(parts) == 'ffmpeg -i "my voice.m4a" it\'s.wav'


def test_a_file_that_a_scanner_reads_is_replaced_a_moment_later(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    new, old = tmp_path / "new", tmp_path / "old"
    new.write_text("new", "utf-8")
    old.write_text("old", "utf-8")
    refusals = [PermissionError(13, "in use")] * 2
    real = os.replace

    def replace(*paths):
        if refusals:
            raise refusals.pop()
        real(*paths)

    monkeypatch.setattr(os, "replace", replace)
    monkeypatch.setattr(writing.time, "sleep", lambda _: None)
    writing.replace_file(new, old)
    assert (old.read_text("utf-8"), refusals) == ("new", [])


def test_files_of_dead_processes_are_deleted_on_windows(tmp_path, monkeypatch):
    ended = subprocess.Popen([sys.executable, "-c", ""])  # a zombie until it is waited for
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    os.waitid(os.P_PID, ended.pid, os.WEXITED | os.WNOWAIT)
    host = temporary.this_process().partition("-")[0]
    for process in (ended.pid, gone.pid, os.getpid()):
        (tmp_path / temporary.temporary_name(str(process), f"{host}-{process}")).touch()
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "WinDLL", as_windows.WinDLL, raising=False)
    monkeypatch.setattr(ctypes, "get_last_error", lambda: 87, raising=False)
    temporary.sweep(tmp_path, again=True)
    assert [one.name.split(".")[1] for one in tmp_path.iterdir()] == [str(os.getpid())]
    ended.wait()


def ran(code):
    """Run Python, and return what it prints."""
    return subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, encoding="utf-8", timeout=60
    ).stdout


def test_a_closed_console_ends_a_command_as_ctrl_c_does():
    told = ran("""
import signal
signal.SIGBREAK = signal.SIGUSR1  # Windows has it, and Ctrl-Break and a closed console send it
from lipsync_lang.base.files.signals import Terminated, terminating, undisturbed
try:
    with terminating():
        with undisturbed():
            signal.raise_signal(signal.SIGBREAK)
            print("whole")
        print("not reached")
except Terminated as ended:
    print(ended.code - 128 == signal.SIGUSR1)
""")
    assert told.split() == ["whole", "True"]


@pytest.mark.parametrize(("platform", "forks"), [("darwin", False), ("linux", True)])
def test_a_process_with_loaded_libraries_is_forked_on_linux_alone(platform, forks):
    code = f"import sys; sys.platform = {platform!r}\n"
    module = "lipsync_lang.text.phonology.espeak.espeak_stream"
    assert ran(f"{code}from {module} import FORKS; print(FORKS)") == f"{forks}\n"


def test_a_file_that_stays_open_elsewhere_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")

    def replace(*_):
        error = PermissionError(13, "Access is denied")
        error.winerror = 5
        raise error

    monkeypatch.setattr(os, "replace", replace)
    monkeypatch.setattr(writing.time, "sleep", lambda _: None)
    path = tmp_path / "lines.csv"
    path.write_text("old", "utf-8")
    with pytest.raises(ll.OutputError, match="open in another program"), \
            atomic(path) as stream:  # fmt: skip
        stream.write(b"new")
    assert [one.name for one in tmp_path.iterdir()] == ["lines.csv"]


def test_locks_are_those_of_msvcrt_where_fcntl_is_missing(tmp_path, monkeypatch):
    taken = []

    class Locks:
        LK_NBLCK = 2

        @staticmethod
        def locking(descriptor, mode, count):
            os.fstat(descriptor)
            if taken:
                raise OSError(36, "Resource deadlock avoided")
            taken.append((mode, count))

    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setitem(sys.modules, "msvcrt", Locks)
    held = claim(tmp_path / "lock")
    assert claim(tmp_path / "lock") is None
    os.close(held)
    assert taken == [(2, 1)]


def test_a_pool_has_no_more_processes_than_windows_waits_for(monkeypatch):
    monkeypatch.setattr(child_processes, "MOST_PROCESSES", 2)
    with child_processes.child_pool(3) as pool:
        assert pool._max_workers == 2  # noqa: SLF001 it has no other name


def test_outputs_on_another_drive_lead_outside(tmp_path):
    """`ntpath.commonpath` raises an error for two drives; the check does not call it."""
    assert not PureWindowsPath("D:/x").is_relative_to(PureWindowsPath("C:/x"))
    with pytest.raises(ValueError, match="drive"):
        ntpath.commonpath(["C:/x", "D:/x"])
    (tmp_path / "away").mkdir()
    home = tmp_path / "home"
    home.mkdir()
    (home / "takes").symlink_to(tmp_path / "away")
    told = []

    class Faults:
        def state(self, _loc, _code, what, _hint):
            told.append(what)

    stated = [((), "takes/{id}.csv"), ((), "other/{id}.csv")]
    output_paths.check_links(stated, home, Faults())
    assert len(told) == 1
    assert "leads outside" in told[0]


@pytest.mark.parametrize(
    ("platform", "stated", "encoding"),
    [("win32", None, "utf-8"), ("win32", "cp437", "cp1252"), ("linux", None, "cp1252")],
)
def test_pipes_are_utf8_on_windows(monkeypatch, platform, stated, encoding):
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.delenv("PYTHONIOENCODING", raising=False)
    if stated:
        monkeypatch.setenv("PYTHONIOENCODING", stated)
    out = io.TextIOWrapper(io.BytesIO(), "cp1252")
    monkeypatch.setattr(sys, "stdout", out)
    assert main(["transcribe", "no", "-l", "ipa:lg"]) in (0, 2)
    assert out.encoding == encoding


# Commands in Windows' manner

needs_proc = pytest.mark.skipif(
    not Path("/proc/self/fd").is_dir(), reason="needs /proc to see which files are open"
)
ODD = "Mein Spiel – テスト"
"""Name of a folder with spaces, and with letters of several code pages."""


@pytest.fixture
def game(tmp_path):
    """A project in a folder of an odd name, written by an editor of Windows."""
    folder = tmp_path / ODD
    folder.mkdir()
    Game(folder, None)
    for path in [folder / "lipsync.yaml", folder / "script.csv"]:
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    return folder


@pytest.fixture
def start(game, tmp_path, monkeypatch):
    """Run a command in the folder of the game, and return its outputs and its exit code."""
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "Ablage – キャッシュ"))
    for name in ("PYTHONIOENCODING", "PYTHONUTF8"):
        monkeypatch.delenv(name, raising=False)

    def run(*arguments, **options):
        return subprocess.run(
            [sys.executable, str(SCRIPT), *arguments], check=False, cwd=game, timeout=300,
            capture_output=True, encoding="utf-8", **options,
        )  # fmt: skip

    return run


@needs_proc
def test_the_imitation_refuses_what_windows_refuses(tmp_path):
    code = """
import os, signal, sys, types
ours = types.ModuleType("lipsync_lang.asking")
exec('''
import os, signal, sys
assert (os.name, sys.platform) == ("nt", "win32")
assert not hasattr(os, "fork") and not hasattr(signal, "SIGALRM")
try: import fcntl
except ImportError: pass
else: raise AssertionError
with open("held", "w", encoding="utf-8"):
    for act in (lambda: os.unlink("held"), lambda: os.replace("held", "other")):
        try: act()
        except PermissionError as error: assert error.winerror == 32
        else: raise AssertionError
os.unlink("held")
for act in (lambda: open("a:b", "w"), lambda: os.mkdir("con"), lambda: os.symlink("a", "b")):
    try: act()
    except OSError as error: assert error.winerror in (123, 1314)
    else: raise AssertionError
''', ours.__dict__)
assert hasattr(os, "fork") is False  # the code of a test counts as ours
print("kept")
"""
    path = f"import sys; sys.path.insert(0, {str(SCRIPT.parent)!r})\n"
    first = f"{path}import as_windows; as_windows.become_windows()"
    done = subprocess.run(
        [sys.executable, "-c", first + code], check=False, cwd=tmp_path, timeout=60,
        capture_output=True, encoding="cp1252",
    )  # fmt: skip
    assert (done.stdout.split(), done.stderr) == (["kept"], "")


@needs_proc
def test_timings_become_files_and_a_pipe_carries_utf8(start, game):
    done = start("run", "--schedule", "vo/map.json", "-o", "Grüße – マップ.csv", "-o", "map.html")
    assert done.returncode == 0, done.stderr
    assert "wrote Grüße – マップ.csv" in done.stderr
    piped = start("run", "--schedule", "-", "-o", "csv:-", input=(game / "vo/map.json").read_text())
    assert piped.stdout == (game / "Grüße – マップ.csv").read_text("utf-8")
    assert "\r" not in (game / "Grüße – マップ.csv").read_bytes().decode("utf-8")
    done = start("languages", "list")
    assert "Bokmål" in done.stdout or "norwegian" in done.stdout
    done = start("run", "--schedule", "vo/map.json", "-o", "con.csv")
    assert done.returncode == 2
    assert "cannot be written" in done.stderr
    assert not list(game.rglob("*.lipsync-tmp"))


@full
@needs_proc
def test_a_build_by_several_processes_goes_on_after_changes(start, game):
    more = [f"more{number}" for number in range(200)]
    for name in more:
        (game / f"vo/{name}.json").write_bytes((game / "vo/map.json").read_bytes())
    with (game / "script.csv").open("a", encoding="utf-8", newline="") as script:
        script.writelines(f"{name},{name}\r\n" for name in more)
    first = start("build", "--workers", "2", "--json", "--report", "report.html")
    assert first.returncode == 0, first.stderr
    assert json.loads(first.stdout.splitlines()[-1])["built"] == 204
    assert (game / "report.html").stat().st_size
    done = start("bank", "draft", "-l", "english", "-c", "facefx", "--write", "l-ow")
    assert done.returncode == 0, done.stderr
    again = start("build", "--workers", "2", "--json")
    assert json.loads(again.stdout.splitlines()[-1])["current"] == 203
    assert start("validate").stderr == "0 faults, 0 warnings\n", "of packs with CRLF too"


@full
@needs_proc
@pytest.mark.parametrize(
    "arguments",
    [
        ("resolve", "-l", "english", "-c", "facefx", "--json"),
        ("explain", "--schedule", "vo/map.json", "--at", "0.1"),
        ("coverage", "script.csv", "-o", "Deckung – 範囲.html"),
        ("posesets", "new", "thing", "open", "wide"),
        ("run", "--schedule", "vo/map.json", "-o", "map.glb", "-o", "map.usda"),
        ("run", "--schedule", "vo/map.json", "--plot", "Kurven – 曲線.png"),
        ("run", "--schedule", "vo/map.json", "-o", "Film – 映画.mp4"),
        ("run", "Hello, people", "-o", "speech.html", "-o", "speech.wav"),
        ("run", "مرحبا", "-l", "arabic", "-o", "مرحبا.csv"),
        ("study", "new", "script.csv", "--method", "ours", "--method", "keyframes", "--tts", "none",
         "--pairs", "2", "--workers", "2", "-o", "Studie – 研究"),
    ],
    ids=lambda arguments: " ".join(arguments[:2]) + f" {arguments[-1]}",
)  # fmt: skip
def test_commands_end_well_in_windows_manner(start, game, arguments):
    done = start(*arguments)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert not list(game.rglob("*.lipsync-tmp"))
