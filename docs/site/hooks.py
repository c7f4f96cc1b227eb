# ruff: noqa: D103 - hooks that MkDocs calls by their names
"""Build the site from pages that read well on GitHub too.

- The navigation is the index, `docs/README.md`: its headings are sections, and the links of its
  list items are the pages.
- Pages of the repository's root belong to the site. Links between the folders stay as GitHub
  needs them, and lead to the right page here.
- Scripts and data are left out, but for `downloads`. One that a page links to is copied as text.
- A moving picture with a film beside it is that film, with controls and sound.
- Markdown between tags of HTML is Markdown, as on GitHub.
- The headings of a table's columns say how long its texts are, for the widths in site.css.
- Blocks that tests run state a file (`title`, `edits`, `shows`) and an exit code. Here they get a
  title.
"""

import posixpath
import re
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
DOWNLOADS = DOCS / "downloads"

SHOWN = {".md", ".png", ".jpg", ".gif", ".svg", ".webp", ".webm", ".mp4", ".wav", ".css", ".js"}
"""Suffixes of the files that a browser shows, or pages need."""

FENCE = re.compile(
    r"^(?P<indent> *)(?P<ticks>`{3,})(?P<language>\w*) *(?P<told>[^\n`]*)\n"
    r"(?P<text>.*?)^(?P=indent)(?P=ticks) *$",
    re.MULTILINE | re.DOTALL,
)
"""A fenced block of code."""

LINK = re.compile(r"(?P<before>\]\()(?P<path>[^)#\s]+)(?P<anchor>#[^)\s]*)?(?P<after>\))")
"""An inline link, or the picture in one."""

GLOSSARY = DOCS / "reference/glossary.md"
HOVER = re.compile(r"<!-- hover: ([^>]+) -->")
"""The words of the glossary whose meaning shows at a pointer."""

API = re.compile(r"^<!-- api: ([\w.]+?(\w+)) -->\n.*?^<!-- end -->$", re.MULTILINE | re.DOTALL)
"""A summary of an object, which the object's whole documentation replaces here."""

TABLE = re.compile(r"<table>.*?</table>", re.DOTALL)
CELL = re.compile(r"<t([hd])\b[^>]*>(.*?)</t\1>", re.DOTALL)
PICTURE = re.compile(r"!\[(?P<told>[^\]]*)\]\((?P<path>[^)\s]+\.webp)\)")
"""A moving picture; a film of the same name beside it has the sound."""

LENGTHS = {250: "passage", 80: "sentence", 20: "words"}
"""Classes of columns by the characters that their longest cell exceeds, longest first."""
WIDE = re.compile(r'<th class="(sentence|passage)"')

TITLES = {"title": "{}", "edits": "Changes in {}", "shows": "From {}"}
"""The title of a block by its attribute."""


# The navigation


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    config.nav = navigation(DOCS / "README.md")
    return config


def navigation(index: Path) -> list[Any]:
    """Return the navigation that an index page states.

    Headings of the second level are sections and those of the third are groups in them. Links in
    list items are pages. A section that links to a page which is an index itself has its pages too.
    """
    nav: list[Any] = [{"Home": "README.md"}]
    section: list[Any] = []
    group = section
    for line in FENCE.sub("", index.read_text(encoding="utf-8")).split("\n"):
        if line.startswith("## "):
            section = group = []
            nav.append({line[3:].strip(): section})
        elif line.startswith("### "):
            group = []
            section.append({line[4:].strip(): group})
        elif line.startswith(("- ", "  ")):
            group += [{title: uri} for title, uri in _entries(line, index)]
    return [part for part in nav if all(part.values())]


def _entries(line: str, index: Path) -> Iterator[tuple[str, str]]:
    """Yield the titles and the addresses of the pages that a line of an index links to."""
    for title, path in re.findall(r"\[([^]]+)\]\(([^)#\s]+\.md)\)", line):
        page = (index.parent / path).resolve()
        yield title.replace("`", ""), address(page)
        if page.name == "README.md" and page.parent not in (DOCS, ROOT):
            for inner in page.read_text(encoding="utf-8").split("\n"):
                if inner.startswith("- "):
                    yield from _entries(inner, page)


# The files


def address(path: Path) -> str:
    """Return the place of a file of the repository among the sources of the site."""
    if path.is_relative_to(DOCS) and (path.suffix in SHOWN or path.parent == DOWNLOADS):
        return path.relative_to(DOCS).as_posix()
    name = path.relative_to(ROOT).as_posix()
    if path.suffix == ".md":
        return f"project/{name.lower()}".replace("readme.md", "about.md")
    return f"files/{name}.txt"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    for file in list(files):
        if file.abs_src_path and not _wanted(Path(file.abs_src_path)):
            files.remove(file)
    pages = [Path(page.abs_src_path) for page in files.documentation_pages()]
    for page in [*pages, *sorted(ROOT.glob("*.md")), ROOT / "findings/README.md"]:
        if not page.is_relative_to(DOCS):
            _add(page, files, config)
        for linked in links(page):
            if linked.is_file() and linked.suffix != ".md":
                _add(linked, files, config)
    return files


def _wanted(path: Path) -> bool:
    """Say whether a file is for readers: files of the theme are, our scripts and data are not."""
    return not path.is_relative_to(DOCS) or path.suffix in SHOWN or path.parent == DOWNLOADS


def _add(path: Path, files: Files, config: MkDocsConfig) -> None:
    uri = address(path)
    if files.get_file_from_path(uri) is None:
        files.append(File.generated(config, uri, abs_src_path=str(path)))


def links(page: Path) -> Iterator[Path]:
    """Yield the files of the repository that a page links to."""
    for found in LINK.finditer(FENCE.sub("", page.read_text(encoding="utf-8"))):
        if ":" not in found["path"]:
            target = (page.parent / found["path"]).resolve()
            if target.is_relative_to(ROOT):
                yield target


# The text


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    del config, files
    source = Path(page.file.abs_src_path)
    meanings = "" if source == GLOSSARY else tooltips(GLOSSARY.read_text(encoding="utf-8"))
    text = markdown.replace("<details>", "<details markdown>")
    text = API.sub(lambda found: f"[](){{ #{found[2].lower()} }}\n\n::: {found[1]}", text)
    parts, at = [], 0
    for block in FENCE.finditer(text):
        parts += [_relinked(text[at : block.start()], source), _fence(block)]
        at = block.end()
    return "".join([*parts, _relinked(text[at:], source), "\n\n", meanings])


def tooltips(glossary: str) -> str:
    """Return an abbreviation, with its meaning, for each word that a glossary marks."""
    entries = re.findall(r"^### (.+)\n\n((?:.+\n)+)", glossary, re.MULTILINE)
    meanings = {title.lower(): _plain(text) for title, text in entries}
    words = [word.strip() for found in HOVER.findall(glossary) for word in found.split(",")]
    return "\n".join(
        f"*[{word}]: {meanings.get(word.lower()) or meanings[word.lower().removesuffix('s')]}"
        for word in words
    )


def _plain(text: str) -> str:
    """Return the text of a paragraph without Markdown and without the link to its page."""
    meaning = " ".join(text.split()).rpartition(" See [")[0]
    return re.sub(r"\[([^]]+)\]\([^)]*\)", r"\1", meaning).replace("`", "")


def _relinked(text: str, source: Path) -> str:
    here = posixpath.dirname(address(source))

    def filmed(found: re.Match[str]) -> str:
        film = (source.parent / found["path"]).resolve().with_suffix(".mp4")
        if not film.is_file():
            return found[0]
        place = posixpath.relpath(address(film), here or ".")
        told = escape(" ".join(found["told"].split()))
        return (
            f'<video controls loop playsinline preload="metadata" src="{place}" '
            f'poster="{place.removesuffix(".mp4")}.webp" aria-label="{told}"></video>'
        )

    def relinked(found: re.Match[str]) -> str:
        target = (source.parent / found["path"]).resolve()
        if ":" in found["path"] or not target.is_relative_to(ROOT):
            return found[0]
        if target.is_dir():
            target /= "README.md"
        path = posixpath.relpath(address(target), here or ".")
        return f"{found['before']}{path}{found['anchor'] or ''}{found['after']}"

    return LINK.sub(relinked, PICTURE.sub(filmed, text))


def _fence(block: re.Match[str]) -> str:
    """Return a block with a title, indented as deep as lists of Python-Markdown need."""
    told = dict(re.findall(r'(\w+)="([^"]*)"', block["told"]))
    titles = [TITLES[name].format(file) for name, file in told.items() if name in TITLES]
    title = f' title="{titles[0]}"' if titles else ""
    indent = " " * (-(-len(block["indent"]) // 4) * 4)
    deeper = indent[len(block["indent"]) :]
    text = "".join(deeper + line for line in block["text"].splitlines(keepends=True))
    ticks = indent + block["ticks"]
    return f"{ticks}{block['language'] or 'text'}{title}\n{text}{ticks}"


# The page


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Tell the tables how long their texts are, and where the address of a test may break.

    On a page without sections a table of sentences has the place of the table of contents.
    """
    del config, files
    html = TABLE.sub(lambda found: _measured(found[0].replace(".py::", ".py::<wbr>")), html)
    if WIDE.search(html) and not any(title.children for title in page.toc):
        page.meta["hide"] = ["toc"]
    return html


def _measured(table: str) -> str:
    """Return a table whose headings have the class of their column's length."""
    rows = [CELL.findall(row) for row in table.split("</tr>")]
    texts = [[re.sub(r"<[^>]+>", "", text) for _, text in row] for row in rows if row]
    columns = zip(*texts, strict=True)
    classes = iter([_length(max(map(len, column))) for column in columns])
    return re.sub(r"<th\b", lambda found: f"{found[0]}{next(classes)}", table)


def _length(characters: int) -> str:
    name = next((name for least, name in LENGTHS.items() if characters > least), "")
    return f' class="{name}"' if name else ""
