"""Documentation: pages, links, packs, commands and Python code are checked."""

import ast
import importlib
import re
from difflib import unified_diff
from importlib.util import find_spec
from pathlib import Path

import pytest
from lanes import needs_plug_ins, swept
from pages import (
    DOING,
    EXTRAS,
    FENCE,
    INSTALLED,
    LEARNED,
    PAGES,
    beyond,
    blocks,
    commands,
    follow_here,
    missing,
    named,
    readme_extras,
    text_of,
    write,
)
from places import ROOT
from syntax_trees import modules, walked

from lipsync_lang.cli import main
from lipsync_lang.packs.models import Language


def generator():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "docs")
        return importlib.import_module("build_reference")


MADE = generator()


# Pages that repeat what the code says


@pytest.mark.parametrize("name", sorted(MADE.PAGES))
def test_generated_pages_are_up_to_date(name):
    if name in {"commands.md", "formats.md"} and find_spec("lipsync_lang.plugins") is None:
        pytest.skip("the wing of plug-ins was removed")
    there = (ROOT / "docs/reference" / name).read_text(encoding="utf-8")
    wanted = MADE.page(name)
    differs = "\n".join(unified_diff(there.split("\n"), wanted.split("\n"), name, "code", n=0))
    assert not differs, f"run python docs/build_reference.py\n{differs}"


def test_every_field_of_a_language_says_how_it_is_joined():
    assert set(MADE.JOINED_FIELDS) == set(Language.model_fields)


def test_the_readme_counts_the_languages_and_pose_sets_there_are():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(pattern.search(text.replace("**", "")) for pattern in MADE.COUNTED.values())
    assert MADE.readme(text) == text, "run python docs/build_reference.py"


@needs_plug_ins
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


@needs_plug_ins
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


@needs_plug_ins
def test_the_messages_of_troubleshooting_are_in_the_code():
    page = ROOT / "docs/how-to/troubleshooting.md"
    shown = [text for language, told, text in blocks(page) if language == "text" and not told]
    fragments = [part.strip() for text in shown for part in re.split(r"\.\.\.|\n", text)]
    written = "\n".join(map(messages, modules().values()))
    assert shown, "a sweep over nothing passes"
    assert not [part for part in fragments if part not in written]


def messages(tree):
    """Return the texts of a module, with `...` where an f-string has a value."""
    texts = []
    for node in walked(tree):
        if isinstance(node, ast.JoinedStr):
            parts = [one.value if isinstance(one, ast.Constant) else "..." for one in node.values]
            texts.append("".join(parts))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            texts.append(node.value)
    return "\n".join(texts)


# What a reader does, in the order of the page


@pytest.mark.parametrize(
    "page",
    swept([page for page in DOING if page not in INSTALLED], quick=[ROOT / "README.md"]),
    ids=named,
)
def test_what_a_page_does_can_be_done(page, tmp_path, monkeypatch):
    """`tests/house/test_wheel.py` follows the other pages, with an installed wheel."""
    if module := missing(page):
        pytest.skip(f"{named(page)} needs {module}, which is an extra")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / ".cache"))
    monkeypatch.delenv("LIPSYNC_LANG_PATH", raising=False)
    follow_here(page)


# What a reader has: the README's installation, and any shell


@pytest.mark.parametrize("page", LEARNED, ids=named)
def test_a_page_names_the_extras_that_the_readme_does_not_install(page):
    told = {extra for names in EXTRAS.findall(text_of(page)) for extra in names.split(",")}
    assert not beyond(page, readme_extras() | told), "state `pip install` with the extra"


def test_one_set_of_extras_serves_the_tutorials():
    pages = [page for page in LEARNED if page.parent.name == "tutorial"]
    assert not [(named(page), more) for page in pages if (more := beyond(page, readme_extras()))]


@pytest.mark.parametrize("page", [ROOT / "README.md", *LEARNED], ids=named)
def test_commands_are_the_same_in_every_shell(page):
    """No command is one that some shell lacks, such as `make`, `cp -r` or a line that goes on.

    The README's first block is for a clone, whose Makefile is there.
    """
    words = {"lipsync-lang", "python", "pip", "pipx", "uv", "npm", "cd", "mkdir"}
    words |= {"make"} if page.parent == ROOT else set()
    for language, _, text in blocks(page):
        for command, _ in commands(text) if language == "console" else ():
            assert command.split()[0] in words, command
            assert not re.search(r"'|\.\./|/bin/|<\(|\$[({\w]|&&|mkdir -p", command), command
        assert language != "console" or not re.search(r"\\$", text, re.MULTILINE), text


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
