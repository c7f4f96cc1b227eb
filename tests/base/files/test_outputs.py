"""Outputs: through links, into pipes and devices, and never over read-only files."""

import errno
import json
import os
import pty
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from build_project import Game
from lanes import full, swept

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files import targets, temporary, writing
from lipsync_lang.base.files.writing import atomic, write_all
from lipsync_lang.production.builds import making

ROWS = [("HH", 0, 0.08), ("AH0", 0.08, 0.15), ("L", 0.15, 0.25), ("OW1", 0.25, 0.5)]
SCHEDULE = json.dumps({"phonemes": [{"label": p, "start": a, "end": b} for p, a, b in ROWS]})
OURS = {**os.environ, "PYTHONPATH": str(Path(writing.__file__).parents[2])}
"""Program for separate processes, independent of the installed one."""

PROGRAM = (sys.executable, "-m", "lipsync_lang")
RUN = ("run", "-l", "english", "-c", "facefx")
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root makes devices")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Change to a folder with a schedule."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.json").write_text(SCHEDULE, "utf-8")
    return tmp_path


def put(path, content=b"new"):
    with atomic(Path(path)) as stream:
        stream.write(content)


def fails(stream):
    stream.write(b"half")
    raise OSError(errno.ENOSPC, "No space left on device")


def names(folder):
    return {path.name for path in Path(folder).iterdir()} - {"line.json"}


def program(*arguments, **more):
    """Run the program in a separate process."""
    return subprocess.run(
        [*PROGRAM, *arguments], capture_output=True, check=False, timeout=300, env=OURS, **more
    )


@contextmanager
def listening(fifo):
    """Read a pipe while the block runs; afterwards the list contains the data."""
    heard = []

    def listen():
        heard.append(Path(fifo).read_bytes())

    reader = threading.Thread(target=listen)
    reader.start()
    try:
        yield heard
    finally:
        reader.join()


# Links


@pytest.mark.parametrize("place", ["target.csv", "there/target.csv"])
def test_a_link_stays_and_its_target_is_written(folder, place):
    target = folder / place
    target.parent.mkdir(exist_ok=True)
    target.write_bytes(b"old")
    (folder / "second.csv").symlink_to(place)
    (folder / "first.csv").symlink_to("second.csv")
    put("first.csv")
    assert target.read_bytes() == b"new"
    assert not target.is_symlink()
    assert (folder / "first.csv").is_symlink()
    assert (folder / "second.csv").is_symlink()
    assert names(target.parent) <= {"first.csv", "second.csv", "target.csv", "there"}


def test_a_link_to_nothing_makes_its_target(folder):
    (folder / "a.csv").symlink_to("b.csv")
    put("a.csv")
    assert (folder / "a.csv").is_symlink()
    assert (folder / "b.csv").read_bytes() == b"new"


def test_a_circle_of_links_is_told(folder):
    (folder / "a.csv").symlink_to("b.csv")
    (folder / "b.csv").symlink_to("a.csv")
    with pytest.raises(OutputError, match=r"a\.csv: is a link that leads in a circle"):
        put("a.csv")
    assert names(folder) == {"a.csv", "b.csv"}


def test_a_failure_leaves_the_target_of_a_link_as_it_was(folder):
    (folder / "target.csv").write_bytes(b"old")
    (folder / "link.csv").symlink_to("target.csv")
    with pytest.raises(OutputError, match="No space left"), atomic(Path("link.csv")) as stream:
        fails(stream)
    assert (folder / "target.csv").read_bytes() == b"old"
    assert names(folder) == {"link.csv", "target.csv"}


# Devices and pipes


def test_a_pipe_is_written_and_stays_a_pipe(folder):
    os.mkfifo(folder / "pipe.csv")
    with listening("pipe.csv") as heard:
        put("pipe.csv")
    assert heard == [b"new"]
    assert stat.S_ISFIFO((folder / "pipe.csv").stat().st_mode)
    assert names(folder) == {"pipe.csv"}


@as_root
def test_a_device_is_written_and_stays_a_device(folder):
    device = folder / "null"
    os.mknod(device, 0o666 | stat.S_IFCHR, os.makedev(1, 3))
    put(device)
    assert stat.S_ISCHR(device.stat().st_mode)
    assert names(folder) == {"null"}


@as_root
def test_a_full_device_is_told_and_stays(folder):
    device = folder / "full"
    os.mknod(device, 0o666 | stat.S_IFCHR, os.makedev(1, 7))
    with pytest.raises(OutputError, match=r"full: cannot be written: No space left on device"):
        put(device)
    assert stat.S_ISCHR(device.stat().st_mode)


@as_root
def test_a_disk_is_refused(folder):
    os.mknod(folder / "disk", 0o666 | stat.S_IFBLK, os.makedev(7, 200))
    with pytest.raises(OutputError, match=r"disk: is a disk; name a file on it"):
        put("disk")
    assert stat.S_ISBLK((folder / "disk").stat().st_mode)


def test_a_socket_is_refused_and_stays(folder):
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("socket")
        with pytest.raises(OutputError, match=r"socket: is a socket; write to - and pipe it"):
            put("socket")
    assert stat.S_ISSOCK((folder / "socket").stat().st_mode)


@pytest.mark.parametrize("name", ["/dev/fd/1", "/proc/self/fd/1", "link"])
def test_an_open_descriptor_is_written_where_it_stands(folder, name):
    (folder / "link").symlink_to("/proc/self/fd/1")  # as /dev/stdout is, which no test may risk
    with (folder / "out.txt").open("wb") as out:
        out.write(b"before ")
        out.flush()
        code = (
            "from pathlib import Path\nfrom lipsync_lang.base.files import atomic\n"
            f"with atomic(Path({name!r})) as stream: stream.write(b'new ')\n"
            "print('after')"
        )
        subprocess.run([sys.executable, "-c", code], stdout=out, check=True, timeout=300, env=OURS)
    assert (folder / "out.txt").read_bytes() == b"before new after\n"
    assert names(folder) == {"link", "out.txt"}


# Modes


def test_a_read_only_file_is_refused_by_its_bits_even_for_root(folder):
    path = folder / "a.csv"
    path.write_bytes(b"old")
    path.chmod(0o444)
    (folder / "link.csv").symlink_to("a.csv")
    for name in ("a.csv", "link.csv"):
        with pytest.raises(OutputError, match=rf"{name}: is read-only; .*chmod u\+w"):
            put(name)
    assert path.read_bytes() == b"old"
    assert names(folder) == {"a.csv", "link.csv"}


@as_root
def test_a_read_only_folder_is_told_and_a_file_of_somebody_else():
    with TemporaryDirectory(dir="/tmp") as closed:
        Path(closed, "theirs.csv").write_bytes(b"old")
        Path(closed).chmod(0o555)
        os.seteuid(65534)
        try:
            with pytest.raises(OutputError, match=rf"the folder {closed} is read-only; make it"):
                put(f"{closed}/a.csv")
            with pytest.raises(OutputError, match=r"theirs.csv: is write-protected; ask its"):
                put(f"{closed}/theirs.csv")
        finally:
            os.seteuid(0)


READ_ONLY = {
    errno.EROFS: "the disk of the folder {} is read-only; make it writable",
    errno.EACCES: "the folder {} is read-only; make it writable (chmod u+w) or ask its owner",
}


@pytest.fixture(params=READ_ONLY, ids=["disk", "folder"])
def locked(request, monkeypatch):
    """Make every new file and folder fail as on a read-only place, and return the words."""

    def refused(path, *_, **__):
        raise OSError(request.param, os.strerror(request.param), str(path))

    def lock():
        monkeypatch.setattr(targets, "may_write", lambda _: False)
        monkeypatch.setattr(os, "open", refused)
        monkeypatch.setattr(os, "mkdir", refused)

    return lock, READ_ONLY[request.param]


def test_a_read_only_place_is_named_with_its_cure(cli, locked):
    lock, words = locked
    pair = ("-l", "english", "-c", "facefx")
    assert cli("run", *pair, "--schedule", "line.json").code == 0  # compiled and cached
    lock()
    for command in (
        ("run", *pair, "--schedule", "line.json", "-o", "a.csv"),
        ("bank", "draft", *pair, "--write", "bmp-iy"),
        ("new", "game"),
        ("new", "game", "--example", "game"),
    ):
        ended = cli(*command)
        assert (ended.code, words.format(".") in ended.err) == (2, True), ended.err


def test_a_build_in_a_read_only_place_names_it_with_its_cure(folder, capsys, locked):
    lock, words = locked
    game = Game(folder, capsys)
    lock()
    assert f"{words.format(folder)}, or copy the project to another folder" in game.build().err


def test_a_read_only_folder_of_outputs_ends_a_build(folder, capsys, locked, monkeypatch):
    lock, words = locked
    game = Game(folder, capsys)
    created = making.created

    def locked_when_made(*places):
        lock()
        return created(*places)

    monkeypatch.setattr(making, "created", locked_when_made)
    told = game.build("--workers", "1")
    assert told.code == 2
    assert f"{words.format('takes')}; 4 of 4 lines were tried" in told.err
    assert "free some space" not in told.err


def test_a_build_does_not_replace_a_read_only_file(folder, capsys):
    game = Game(folder, capsys)
    assert game.build().code == 0
    (folder / "takes" / "low.csv").chmod(0o444)
    before = game.takes()
    game.say("low", "L OW M")
    (failed,) = (one for one in game.build().events if one.get("outcome") == "failed")
    assert failed["message"].startswith("script.csv:2: takes/low.csv: is read-only; open it in")
    assert game.takes() == before


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755, 0o664])
def test_a_file_keeps_its_mode(folder, mode):
    path = folder / "a.csv"
    path.write_bytes(b"old")
    path.chmod(mode)
    put("a.csv")
    assert path.read_bytes() == b"new"
    assert stat.S_IMODE(path.stat().st_mode) == mode


@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_a_new_file_gets_the_usual_mode_and_the_mask_is_never_touched(folder, monkeypatch, mask):
    before = os.umask(mask)
    try:
        monkeypatch.setattr(os, "umask", lambda _: pytest.fail("other threads see it too"))
        put("a.csv")
    finally:
        monkeypatch.undo()
        os.umask(before)
    assert stat.S_IMODE((folder / "a.csv").stat().st_mode) == 0o666 & ~mask


@as_root
def test_root_leaves_a_file_to_its_owner(folder):
    path = folder / "a.csv"
    path.write_bytes(b"old")
    os.chown(path, 65534, 65534)
    put("a.csv")
    assert (path.stat().st_uid, path.stat().st_gid) == (65534, 65534)


# Several at once


def test_of_several_outputs_none_appears_until_all_are_prepared(folder):
    (folder / "a.csv").write_bytes(b"old")
    os.mkfifo(folder / "pipe")
    seen = []

    def look(stream):
        stream.write(b"second")
        seen.append(((folder / "a.csv").read_bytes(), (folder / "b.csv").exists()))

    with pytest.raises(OutputError, match=r"c\.csv: cannot be written: No space left"):
        write_all({
            Path("pipe"): lambda stream: stream.write(b"never"),
            Path("a.csv"): lambda stream: stream.write(b"first"),
            Path("b.csv"): look,
            Path("c.csv"): fails,
        })  # fmt: skip
    assert seen == [(b"old", False)]
    assert (folder / "a.csv").read_bytes() == b"old"
    assert names(folder) == {"a.csv", "pipe"}


def test_a_signal_waits_until_all_are_in_their_places(folder, monkeypatch):
    replace = Path.replace

    def interrupted(self, target):
        signal.raise_signal(signal.SIGINT)
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", interrupted)
    outputs = {Path(name): lambda stream: stream.write(b"new") for name in ("a.csv", "b.csv")}
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            write_all(outputs)
    finally:
        signal.signal(signal.SIGINT, before)
    assert names(folder) == {"a.csv", "b.csv"}


def test_sources_are_on_the_disk_before_they_are_in_place(folder, monkeypatch):
    done = []
    monkeypatch.setattr(os, "fsync", lambda handle: done.append(os.fstat(handle).st_mode))
    replace = Path.replace
    monkeypatch.setattr(Path, "replace", lambda *both: (done.append("rename"), replace(*both)))
    put("a.csv")
    assert done == ["rename"], "an output of thousands need not wait for the disk"
    done.clear()
    write_all({Path("pack.yaml"): lambda stream: stream.write(b"kind")}, durable=True)
    assert stat.S_ISREG(done[0])
    assert done[1] == "rename"
    assert stat.S_ISDIR(done[2])
    assert (folder / "pack.yaml").read_bytes() == b"kind"


def test_a_bank_that_is_edited_is_synced(folder, cli, monkeypatch):
    synced = []
    monkeypatch.setattr(os, "fsync", synced.append)
    assert cli("bank", "draft", *RUN[1:], "--write", "l-ow").code == 0
    assert len(synced) == 2, "the file and its folder"
    assert (folder / "posesets/facefx/banks/common.yaml").is_file()


# What ends a command

HANGING = """
import signal, sys, time
from lipsync_lang import cli
from lipsync_lang.animations.animation_writers import WRITERS, writer

@writer("hanging", suffix=".hang")
def hang(animation, out):
    "Never done."
    print("ready", flush=True)
    time.sleep(600)

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
signal.signal(signal.SIGHUP, signal.SIG_DFL)
sys.exit(cli.main(sys.argv[1:]))
"""


def stopped(number, *outputs):
    """Start a command, end it by a signal while it writes, and return its exit code."""
    command = [sys.executable, "-c", HANGING, *RUN, "--schedule", "line.json", *outputs]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=OURS
    ) as process:
        assert process.stdout.readline() == b"ready\n"
        process.send_signal(number)
        _, told = process.communicate(timeout=300)
    assert b"Traceback" not in told
    return process.returncode


@pytest.mark.parametrize(
    ("number", "code"),
    swept([(signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129)]),
)
def test_a_command_that_is_ended_leaves_nothing(folder, number, code):
    assert stopped(number, "-o", "a.csv", "-o", "b.hang") == code
    assert names(folder) == set()


@full
def test_what_a_killed_command_leaves_is_swept_by_the_next(folder):
    (folder / ".mine.csv").write_text("hidden, and nobody's business")
    assert stopped(signal.SIGKILL, "-o", "a.csv", "-o", "b.hang") == -signal.SIGKILL
    left = names(folder) - {".mine.csv"}
    assert len(left) == 2
    assert all(name.endswith(".lipsync-tmp") for name in left)
    put("c.csv")
    assert names(folder) == {".mine.csv", "c.csv"}


def test_what_a_living_process_still_writes_is_not_swept(folder):
    with atomic(Path("a.csv")) as stream:
        put("b.csv")
        stream.write(b"new")
    assert names(folder) == {"a.csv", "b.csv"}


@pytest.mark.parametrize(("age", "stays"), [(0, True), (2 * temporary.STALE_SECONDS, False)])
def test_of_another_machine_only_old_files_are_swept(folder, age, stays):
    left = folder / ".a.csv.00000000-1-0123abcd.lipsync-tmp"
    left.write_bytes(b"")
    os.utime(left, (time.time() - age,) * 2)
    put("b.csv")
    assert left.exists() == stays


# Standard output and input


def test_standard_output_takes_bytes_and_words_go_elsewhere(folder):
    ended = program(*RUN, "--schedule", "line.json", "-o", "glb:-", "-o", "a.csv")
    assert ended.returncode == 0
    assert ended.stdout.startswith(b"glTF")
    assert int.from_bytes(ended.stdout[8:12], "little") == len(ended.stdout)
    assert b"wrote a.csv" in ended.stderr
    assert b"wrote -" not in ended.stderr
    assert names(folder) == {"a.csv"}


@pytest.mark.parametrize("name", ["csv", "json", "textgrid"])
def test_standard_output_takes_what_a_file_would_hold(folder, cli, name):
    assert cli(*RUN, "--schedule", "line.json", "-o", f"{name}:a").code == 0
    ended = cli(*RUN, "--schedule", "line.json", "-o", f"{name}:-")
    assert ended.code == 0
    assert ended.out.encode() == (folder / "a").read_bytes()


def test_standard_output_asks_for_a_format(cli):
    ended = cli(*RUN, "--schedule", "line.json", "-o", "-")
    assert ended.code == 2
    assert "-: standard output has no suffix; name the format, such as csv:-" in ended.err


def test_standard_output_is_given_once(cli):
    ended = cli(*RUN, "--schedule", "line.json", "-o", "csv:-", "--plot", "-")
    assert ended.code == 2
    assert "-: is also an output" in ended.err


def test_a_file_may_be_called_like_standard_output(folder, cli):
    assert cli(*RUN, "--schedule", "line.json", "-o", "csv:./-").out == ""
    assert (folder / "-").read_bytes().startswith(b"time_s")


def test_standard_input_is_a_schedule():
    ended = program(*RUN, "--schedule", "-", "-o", "csv:-", input=SCHEDULE.encode())
    assert ended.returncode == 0
    assert ended.stdout.startswith(b"time_s,")


@full
def test_standard_input_is_lines():
    ended = program("transcribe", "-l", "finnish", "--file", "-", "--json", input=b"moi\n\nmoi\n")
    assert [len(one["words"]) for one in json.loads(ended.stdout)] == [1, 1]


@full
@pytest.mark.parametrize(
    ("text", "more"), [("moi\nmoi\n", ()), ("id,fi\n1,moi\n2,moi\n", ("--column", "fi"))]
)
def test_standard_input_is_a_script(text, more):
    ended = program(
        "coverage", "-", "-l", "finnish", "-c", "facefx", *more, "-o", "-", "--format", "json",
        input=text.encode(),
    )  # fmt: skip
    assert ended.returncode == 0
    corpus = json.loads(ended.stdout)["corpus"]
    assert (corpus["lines"], corpus["words"]) == (2, 2)


@full
def test_a_script_may_come_through_a_pipe(folder, cli):
    os.mkfifo(folder / "script.txt")
    writer = threading.Thread(target=lambda: Path("script.txt").write_text("moi\nmoi\n"))
    writer.start()
    ended = cli("coverage", "script.txt", "-l", "finnish", "-c", "facefx", "--format", "json")
    writer.join()
    assert json.loads(ended.out)["corpus"]["lines"] == 2


@full
def test_check_and_pictures_go_to_standard_output(cli):
    ended = program(*RUN, "--schedule", "line.json", "--plot", "-")
    assert ended.stdout.startswith(b"\x89PNG")
    line = ("--schedule", "line.json", "--format", "json")
    assert json.loads(cli("check", *RUN[1:], *line, "-o", "-").out)


@full
def test_a_difference_is_told_elsewhere_while_its_picture_is_printed():
    ended = program("bank", "diff", "-l", "english", "-c", "crab", "--plot", "-")
    assert ended.stdout.startswith(b"\x89PNG")
    assert b"bigram" in ended.stderr


@full
def test_a_reader_who_has_seen_enough_costs_no_file(folder):
    process = subprocess.Popen(
        [*PROGRAM, *RUN, "--schedule", "line.json", "-o", "csv:-", "-o", "a.csv"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=OURS,
    )  # fmt: skip
    process.stdout.close()
    told = process.stderr.read()
    process.stderr.close()
    assert process.wait(300) == 0
    assert told == b""
    assert names(folder) == {"a.csv"}


def on_terminal(*arguments):
    """Run the program on a new terminal, and return its exit code and its output."""
    leader, follower = pty.openpty()
    with subprocess.Popen(
        [*PROGRAM, *arguments], stdout=follower, stderr=follower, env=OURS
    ) as process:
        os.close(follower)
        came = b""
        try:
            while block := os.read(leader, 4096):
                came += block
        except OSError as error:
            if error.errno != errno.EIO:  # how Linux says that the other end is closed
                raise
    os.close(leader)
    return process.returncode, came


@full
def test_a_terminal_takes_text_but_no_bytes():
    code, came = on_terminal(*RUN, "--schedule", "line.json", "-o", "csv:-")
    assert code == 0
    assert b"time_s,open," in came
    code, came = on_terminal(*RUN, "--schedule", "line.json", "-o", "glb:-")
    assert code == 2
    assert b"a terminal cannot show these bytes" in came
    assert b"glTF" not in came


def test_more_than_memory_should_hold_waits_on_the_disk(folder, monkeypatch):
    monkeypatch.setattr(writing, "MAX_SPOOLED_BYTES", 10)
    os.mkfifo(folder / "pipe")
    with listening("pipe") as heard:
        put("pipe", bytes(range(256)))
    assert heard == [bytes(range(256))]


def test_a_folder_of_many_outputs_is_listed_once_a_minute(folder, monkeypatch):
    listed, now = [], [1000.0]
    scan = os.scandir
    monkeypatch.setattr(temporary.os, "scandir", lambda path: listed.append(path) or scan(path))
    monkeypatch.setattr(temporary.time, "monotonic", lambda: now[0])
    for number in range(20):
        put(f"{number}.csv")
    assert len(listed) == 1
    now[0] += temporary.SWEEP_SECONDS
    put("late.csv")
    assert len(listed) == 2
    assert set(listed) == {Path(os.path.realpath(folder))}
