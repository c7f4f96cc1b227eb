"""The documentation site: its navigation, and its conversion of the pages."""

import importlib.util
import json
import os
import re
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import pytest
from lanes import full
from places import ROOT, TESTS
from test_consumers import chromium, found, run, whole_chromium

pytest.importorskip("mkdocs", reason="the site needs mkdocs, which is an extra")
pytest.importorskip("mkdocstrings", reason="the site needs mkdocstrings, which is an extra")

FOREIGN = re.compile(r"^([a-z]+:)?//", re.IGNORECASE)
LOADS = dict.fromkeys(("script", "img", "iframe", "source", "video"), "src") | {"link": "href"}
"""Tags that load files, and the attribute with the address."""


def loaded(name):
    path = ROOT / "docs/site" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"site_{name}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


HOOKS, DOCSTRINGS = loaded("hooks"), loaded("docstrings")
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("findings/*.md")])
assert PAGES, "a sweep over nothing passes"


def entries(nav):
    """Yield the addresses of a navigation at any depth."""
    for part in nav:
        for inner in part.values():
            if isinstance(inner, str):
                yield inner
            else:
                yield from entries(inner)


# The navigation


def test_every_page_is_in_the_index_once():
    listed = list(entries(HOOKS.navigation(ROOT / "docs/README.md")))
    missing = {HOOKS.address(page) for page in PAGES} - set(listed)
    assert not missing, "give each a line in docs/README.md"
    assert len(listed) == len(set(listed))


def test_headings_are_sections_and_groups(tmp_path, monkeypatch):
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner/README.md").write_text("- [One](one.md)\n", "utf-8")
    index = tmp_path / "README.md"
    index.write_text(
        "# T\n\n[no](no.md)\n\n## A\n\n- [`a`](a.md): and\n  [b](b.md), [c](a.md#c)\n\n"
        "### G\n\n- [g](g.md)\n\n"
        "## Empty\n\n## D\n\n- [D](inner/README.md)\n- [code](c.py)\n",
        "utf-8",
    )
    monkeypatch.setattr(HOOKS, "DOCS", tmp_path)
    assert HOOKS.navigation(index) == [
        {"Home": "README.md"},
        {"A": [{"a": "a.md"}, {"b": "b.md"}, {"G": [{"g": "g.md"}]}]},
        {"D": [{"D": "inner/README.md"}, {"One": "inner/one.md"}]},
    ]


# The text


def test_links_between_folders_lead_to_pages_of_the_site():
    page = ROOT / "docs/how-to/x.md"
    text = (
        "[a](../../CONTRIBUTING.md#b) ![c](../images/demo.png) "
        "[d](../../languages/ipa.yaml) [e](#f)"
    )
    assert HOOKS._relinked(text, page) == (  # noqa: SLF001
        "[a](../project/contributing.md#b) ![c](../images/demo.png) "
        "[d](../files/languages/ipa.yaml.txt) [e](#f)"
    )
    text = "[a](docs/decisions/) [b](https://b.org/README.md) [c](README.md)"
    assert HOOKS._relinked(text, ROOT / "CHANGELOG.md") == (  # noqa: SLF001
        "[a](../decisions/README.md) [b](https://b.org/README.md) [c](about.md)"
    )


def test_a_moving_picture_with_a_film_beside_it_is_that_film():
    page, text = ROOT / "docs/gallery.md", '![A "mouth"](images/gallery-crab.webp)'
    assert HOOKS._relinked(text, page) == (  # noqa: SLF001
        '<video controls loop playsinline preload="metadata" src="images/gallery-crab.mp4" '
        'poster="images/gallery-crab.webp" aria-label="A &quot;mouth&quot;"></video>'
    )
    assert "<video" not in HOOKS._relinked(text, ROOT / "README.md")  # noqa: SLF001 no such film
    text = "![A face](docs/images/talking.webp)"
    assert 'src="../images/talking.mp4"' in HOOKS._relinked(text, ROOT / "README.md")  # noqa: SLF001


@pytest.mark.parametrize(
    ("block", "shown"),
    [
        ('```yaml title="a.yaml"\nb\n```', '```yaml title="a.yaml"\nb\n```'),
        ('```yaml edits="a.yaml"\nb\n```', '```yaml title="Changes in a.yaml"\nb\n```'),
        ('```text shows="a.csv"\nb\n```', '```text title="From a.csv"\nb\n```'),
        ("```console exit=1\n$ a\n```", "```console\n$ a\n```"),
        ("```\na\n```", "```text\na\n```"),
        ("- a\n\n  ```py\n  b\n    c\n  ```", "- a\n\n    ```py\n    b\n      c\n    ```"),
    ],
)
def test_blocks_say_which_file_they_are(block, shown):
    found = HOOKS.FENCE.sub(HOOKS._fence, block)  # noqa: SLF001
    assert found == shown


def test_the_words_that_the_glossary_marks_have_its_meanings():
    glossary = (ROOT / "docs/reference/glossary.md").read_text(encoding="utf-8")
    words = re.findall(r"^\*\[(.+?)\]: (.+)$", HOOKS.tooltips(glossary), re.MULTILINE)
    assert len(words) == HOOKS.HOVER.search(glossary)[1].count(",") + 1
    assert not [word for word, meaning in words if re.search(r"[\[`]|See", meaning)]
    assert dict(words)["phone bigrams"] == dict(words)["phone bigram"]


def test_every_entry_of_the_glossary_names_its_page():
    glossary = (ROOT / "docs/reference/glossary.md").read_text(encoding="utf-8")
    entries = re.split(r"^### ", glossary, flags=re.MULTILINE)[1:]
    assert entries, "a sweep over nothing passes"
    assert not [entry for entry in entries if "](" not in entry]


def test_meanings_of_parameters_are_no_types():
    told = "Do.\n\nParameters\n----------\na, b : of it\n    and more\n\nRaises\n------\nE : no\n"
    assert DOCSTRINGS.rewritten(told) == (
        "Do.\n\nParameters\n----------\na, b\n    of it\n    and more\n\nRaises\n------\nE : no\n"
    )


def test_a_sentence_about_the_result_is_no_type():
    told = "Do.\n\nReturns\n-------\nA thing, or\nanother\n\nRaises\n------\nE\n    no\n"
    assert DOCSTRINGS.rewritten(told) == (
        "Do.\n\nReturns\n-------\n:\n    A thing, or\n    another\n\nRaises\n------\nE\n    no\n"
    )


def test_headings_of_columns_say_how_long_the_texts_are():
    rows = [("<th>", "n", "name", "why"), ("<td>", "1", "w" * 21, f"<code>{'w' * 81}</code>")]
    table = "".join(
        f"<tr>{''.join(f'{tag}{text}{tag[0]}/{tag[1:]}' for text in texts)}</tr>"
        for tag, *texts in rows
    )
    shown = HOOKS.TABLE.sub(lambda found: HOOKS._measured(found[0]), f"<table>{table}</table>")  # noqa: SLF001
    found = re.findall(r"<th[^>]*>", shown)
    assert found == ["<th>", '<th class="words">', '<th class="sentence">']
    assert re.sub(r' class="\w+"', "", shown) == f"<table>{table}</table>"


# The built site


class Built(HTMLParser):
    """A page as built: its anchors, its links, and the files it loads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loads, self.text = set(), [], [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        told = dict(attrs)
        self.anchors |= {told.get("id"), told.get("name")} - {None}
        if tag == "a" and told.get("href"):
            self.links.append(told["href"])
        if tag in LOADS and told.get(LOADS[tag]) and told.get("rel") != "canonical":
            self.loads.append(told[LOADS[tag]])

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build the site strictly, without warnings."""
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", folder],
        cwd=ROOT, capture_output=True, encoding="utf-8", check=False,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    return folder


@pytest.fixture(scope="module")
def pages(site):
    # An example may have a page of its own, which is copied as it is.
    own = {path.relative_to(ROOT / "docs") for path in (ROOT / "docs/examples").rglob("*.html")}
    every = (path for path in sorted(site.rglob("*.html")) if path.relative_to(site) not in own)
    return {path: Built(path) for path in every if path.name != "404.html"}


def leads(page, link):
    """Return the file and the anchor of a link."""
    parts = urlsplit(link)
    there = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    return there, unquote(parts.fragment)


@full
@pytest.mark.xdist_group("site")
def test_every_page_is_built(site, pages):
    built = {path.relative_to(site).as_posix() for path in pages}
    wanted = {
        re.sub(r"(^|/)README\.html$", r"\1index.html", f"{HOOKS.address(page)[:-3]}.html")
        for page in PAGES
    }
    assert built == wanted


@full
@pytest.mark.xdist_group("site")
def test_no_link_and_no_anchor_is_broken(site, pages):
    broken = []
    for path, page in pages.items():
        for link in [*page.links, *page.loads]:
            if not re.match(r"^([a-z]+:|//)", link):
                there, anchor = leads(path, link)
                there = there / "index.html" if there.is_dir() else there
                if not there.is_file() or (anchor and anchor not in pages[there].anchors):
                    broken.append(f"{path.relative_to(site)}: {link}")
    assert not broken


@full
@pytest.mark.xdist_group("site")
def test_nothing_is_loaded_from_another_host(site, pages):
    assert not [load for page in pages.values() for load in page.loads if FOREIGN.match(load)]
    for style in site.rglob("*.css"):
        addresses = re.findall(r"url\(['\"]?([^'\")]+)", style.read_text(encoding="utf-8"))
        assert not list(filter(FOREIGN.match, addresses)), style


@full
@pytest.mark.xdist_group("site")
def test_no_markup_is_left_in_the_text(pages):
    left = re.compile(r"^```|^- \[|\]\([^) ]+\.md|^:::|<!--|^\|.*\|$", re.MULTILINE)
    code = re.compile(r"<(pre|code)\b.*?</\1>|<!--.*?-->|<script.*?</script>", re.DOTALL)
    for path in pages:
        text = re.sub(r"<[^>]+>", "", code.sub("", path.read_text(encoding="utf-8")))
        assert not left.findall(text), path


class Parts(HTMLParser):
    """The headings, lists, tables and pictures of a page, counted."""

    def __init__(self, html):
        super().__init__()
        self.counted = Counter()
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        tag = "img" if tag == "video" else tag  # a moving picture has its sound on the site
        if re.fullmatch("h[1-6]|[ou]l|li|table|t[rd]|pre|img", tag):
            first = dict(attrs).get("start", "1")
            self.counted[tag if first == "1" else f"{tag} from {first}"] += 1


@full
@pytest.mark.xdist_group("site")
def test_the_site_and_github_show_the_same_parts(site):
    markdown_it = pytest.importorskip("markdown_it", reason="a second reader of Markdown")
    reader = markdown_it.MarkdownIt("commonmark").enable("table")
    for source in PAGES:
        text = source.read_text(encoding="utf-8")
        if not HOOKS.API.search(text):  # documentation of objects, which GitHub has in short
            name = re.sub(r"(^|/)README\.md$", r"\1index.md", HOOKS.address(source))
            page = (site / name).with_suffix(".html").read_text(encoding="utf-8")
            article = page[page.index("<article") : page.rindex("</article>")]
            assert Parts(article).counted == Parts(reader.render(text)).counted, source


@full
@pytest.mark.xdist_group("site")
def test_search_knows_every_page(site, pages):
    index = json.loads((site / "search/search_index.json").read_text(encoding="utf-8"))
    known = {entry["location"].partition("#")[0] for entry in index["docs"]}
    assert known == {path.relative_to(site).as_posix() for path in pages}
    script = (site / "search/search_index.js").read_text(encoding="utf-8")
    assert script.startswith("var __index = {"), "the search works from a disk"


@full
@pytest.mark.xdist_group("site")
def test_the_api_page_documents_every_public_name(pages):
    import lipsync_lang as ll

    page = next(built for path, built in pages.items() if path.name == "api.html")
    for name in set(ll.__all__) - {"__version__"}:
        assert name.lower() in page.anchors
    told = re.sub(r"\s+", " ", " ".join(page.text))
    for title in ("Parameters:", "Returns:", "Raises:", "Examples:"):
        assert title in told


@full
@pytest.mark.xdist_group("site")
def test_every_page_fits_a_phone_and_can_be_read_and_found(site):
    node, modules = found("playwright-core")
    browsers = chromium(), whole_chromium()
    shown = run(node, TESTS / "browser/site.mjs", modules, *browsers, site, "trigram")
    assert (shown["said"], shown["asked"]) == ([], [])
    assert (shown["wide"], shown["faint"]) == ([], [])
    assert shown["read"] == len([path for path in site.rglob("*.html") if path.name != "404.html"])
    assert any("trigram" in title.lower() for title in shown["found"])
