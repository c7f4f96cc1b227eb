"""Lint the prose of this project: `python tests/prose/lint.py [FILE ...]`.

A rule of `vocabulary.yaml` is a pattern that is searched for in each sentence. Without files, all
documents and all modules are read.
"""

import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

from lipsync_lang.packs.yaml.events import load_yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from prose.markup import sentences_of_markup
from prose.remarks import sentences_of_comments, sentences_of_pack
from prose.scripts import sentences_of_script
from prose.texts import PLACEHOLDER, ROOT, Sentence, sentences_of_module, sentences_of_page

LONGEST_WORDS = 30
"""A longer sentence is two sentences."""
VOCABULARY = Path(__file__).with_name("vocabulary.yaml")


@dataclass(frozen=True)
class Rule:
    """A pattern that good prose does not hold, with a sentence for each side."""

    name: str
    pattern: re.Pattern[str]
    say: str
    bad: tuple[str, ...]
    good: tuple[str, ...]
    running: bool
    """True if the rule leaves out tables, headings and messages."""
    pages: bool
    """True if the rule leaves out modules."""

    def finds(self, sentence: Sentence) -> re.Match[str] | None:
        """Search a sentence for the pattern."""
        if (self.running and not sentence.running) or (
            self.pages and sentence.path.suffix != ".md"
        ):
            return None
        return self.pattern.search(sentence.text)


@dataclass(frozen=True)
class Finding:
    """A sentence that a rule finds fault with."""

    sentence: Sentence
    name: str
    say: str

    def __str__(self) -> str:
        path = self.sentence.path
        place = path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
        told = f"{place}:{self.sentence.line}: {self.name}: {self.say}\n    {self.sentence.text}"
        return told.replace(PLACEHOLDER, "`...`")


def rules() -> list[Rule]:
    """Read the vocabulary."""
    entries = load_yaml(VOCABULARY.read_text(encoding="utf-8"))
    return [
        Rule(
            name,
            re.compile(entry["find"], 0 if entry.get("case") else re.IGNORECASE),
            entry["say"],
            tuple(entry["bad"]),
            tuple(entry["good"]),
            entry.get("running", False),
            entry.get("pages", False),
        )
        for name, entry in entries.items()
    ]


def documents() -> list[Path]:
    """List all pages."""
    return _listed("*.md", "docs/**/*.md")


def modules() -> list[Path]:
    """List all modules, of the package, its tests, its benchmarks and its documentation."""
    folders = ("lipsync_lang", "tests", "benchmarks", "docs")
    return _listed("*.py", *(f"{folder}/**/*.py" for folder in folders))


def other_files() -> list[Path]:
    """List scripts, templates, packs, tours and settings."""
    package = [f"lipsync_lang/**/*.{kind}" for kind in ("js", "html", "jinja")]
    packs = [f"{folder}/**/*.yaml" for folder in ("languages", "posesets", "docs", "benchmarks")]
    settings = ["*.yml", "*.toml", "Makefile", ".pre-commit-config.yaml", ".github/**/*.yml"]
    return _listed(
        *package, *packs, *settings, "posesets/**/*.json", "docs/**/*.html", "docs/**/*.mjs"
    )


def everything() -> list[Path]:
    """List all files with prose."""
    return [*documents(), *modules(), *other_files()]


def _listed(*patterns: str) -> list[Path]:
    return sorted({path for pattern in patterns for path in ROOT.glob(pattern)})


def sentences(path: Path) -> Iterator[Sentence]:
    """Read a file by its kind."""
    match path.name.removesuffix(".jinja").rpartition(".")[2]:
        case "md":
            return takewhile(_is_recent, sentences_of_page(path))
        case "py":
            return sentences_of_module(path, messages=not path.is_relative_to(ROOT / "tests"))
        case "js" | "mjs":
            return sentences_of_script(path)
        case "html":
            return sentences_of_markup(path)
        case "yaml" | "yml" | "json" if path.suffix != ".jinja":
            return sentences_of_pack(path)
        case _:
            return sentences_of_comments(path)


def _is_recent(sentence: Sentence) -> bool:
    """Tell whether a sentence is no heading of a release: older entries of a changelog stay."""
    return not (sentence.path.name == "CHANGELOG.md" and sentence.text.startswith("[0."))


def findings(paths: Iterable[Path], vocabulary: list[Rule]) -> Iterator[Finding]:
    """Check the prose of files."""
    for path in paths:
        for sentence in sentences(path):
            yield from faults(sentence, vocabulary)


def faults(sentence: Sentence, vocabulary: list[Rule]) -> Iterator[Finding]:
    """Check a sentence."""
    for rule in vocabulary:
        if match := rule.finds(sentence):
            yield Finding(sentence, rule.name, f"'{match[0]}': {rule.say}")
    words = len(re.findall(r"\S*[^\W\d]\S*|\x00", sentence.text))
    if sentence.running and words > LONGEST_WORDS:
        yield Finding(sentence, "length", f"{words} words: make two sentences of this one")


def main(arguments: list[str]) -> int:
    """Print the findings of files, and count them."""
    paths = [Path(argument).resolve() for argument in arguments] or everything()
    found = list(findings(paths, rules()))
    for finding in found:
        print(finding)
    print(f"{_counted(len(found), 'finding')} in {_counted(len(paths), 'file')}")
    return 1 if found else 0


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" + "s" * (count != 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
