# ruff: noqa: E501 - lines of the pages
"""Write the figures of the pages that set this program beside the paper.

    python docs/the_paper.py

Text between the marks `made: NAME` and `end` of `coverage.md` and `the-paper.md` in
`docs/explanation` is generated. It comes from `docs/paper.yaml`, the figures of the paper, and
`docs/paper-items.yaml`, its items, from the texts in `docs/corpora`, and from the packs. `tests/docs/test_the_paper.py` generates it again and compares.
"""

import json
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import accumulate, pairwise
from pathlib import Path
from statistics import correlation, fmean
from types import SimpleNamespace
from typing import Any

from how_good import table, written

from lipsync_lang import transcribe
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.events import load_yaml
from lipsync_lang.pipeline.motion import PRESETS
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.reports.coverage.report import CoverageReport
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.text.lines import read_lines
from lipsync_lang.text.lines.line_readers import Line

DOCS = Path(__file__).parent
PAPER: Mapping[str, Any] = load_yaml((DOCS / "paper.yaml").read_text("utf-8"))
ITEMS: Sequence[Mapping[str, Any]] = load_yaml((DOCS / "paper-items.yaml").read_text("utf-8"))
MEASURED: Mapping[str, Any] = json.loads((DOCS / "measured.json").read_text("utf-8"))
PAGES = tuple(DOCS / "explanation" / name for name in ("coverage.md", "the-paper.md"))

MAPPINGS = {"english": "default", "paper-english": "Table 1"}
"""Languages that are counted, and how a page calls their mappings."""

FACE = "facefx"
"""The pose set of the paper; which one is of no effect on counts."""

MINUTES_OF_AN_HOUR = 60


def lines_of(name: str) -> list[Line]:
    """Return the lines of a text in `docs/corpora`."""
    return [*read_lines([DOCS / "corpora" / f"{name}.txt"])]


@cache
def corpora() -> Mapping[str, Sequence[Line]]:
    """Return the corpora by their names."""
    sentences, dialogue = lines_of("harvard-sentences"), lines_of("the-question")
    return {
        "sentences": sentences[:200],
        "mixed": [*dialogue, *sentences[:130]],
        "dialogue": dialogue,
        "all": sentences,
    }


@dataclass(frozen=True)
class Counted:
    """A corpus, counted with one mapping of English."""

    report: CoverageReport

    @property
    def total(self) -> int:
        """Number of bigrams as they occur, without silence."""
        return self.report.occurrences

    @cached_property
    def counts(self) -> dict[str, int]:
        """Occurrences of each bigram, most frequent first."""
        return {one.bigram: one.count for one in self.report.bigrams}

    def percent(self, bigram: str) -> float:
        """Return the share of a bigram in percent."""
        return 100 * self.counts.get(bigram, 0) / self.total

    def first(self, number: int) -> float:
        """Return the share of the most frequent bigrams in percent."""
        return 100 * sum([*self.counts.values()][:number]) / self.total

    def needed(self, percent: float) -> int:
        """Return the number of most frequent bigrams that make a share of the speech."""
        running = accumulate(self.counts.values())
        return next(n for n, one in enumerate(running, 1) if 100 * one >= percent * self.total)

    @property
    def unused(self) -> int:
        """Number of bigrams that never occur."""
        return len(self.report.unused)

    @property
    def hours(self) -> float:
        """Hours to draw all bigrams that occur."""
        return len(self.counts) * PAPER["minutes"] / MINUTES_OF_AN_HOUR

    def most_frequent(self) -> str:
        """Return the most frequent phoneme with its share."""
        name, count = max(self.report.phonemes.items(), key=lambda one: one[1])
        return f"`{name}`, {100 * count / sum(self.report.phonemes.values()):.1f} %"

    def table_2(self) -> list[float]:
        """Return the shares of the bigrams of Table 2, in its order."""
        return [self.percent(bigram) for bigram in PAPER["table_2"]]

    def likeness(self) -> tuple[int, float, float]:
        """Compare with Table 2: shared bigrams among the first 21, mean difference, Pearson's r."""
        printed, own = [*PAPER["table_2"].values()], self.table_2()
        shared = len({*[*self.counts][: len(printed)]} & {*PAPER["table_2"]})
        differences = [abs(a - b) for a, b in zip(printed, own, strict=True)]
        return shared, fmean(differences), correlation(printed, own)


@cache
def counted(corpus: str) -> Mapping[str, Counted]:
    """Count a corpus with each mapping of English."""
    found = coverage(corpora()[corpus], [*MAPPINGS], FACE)
    return {report.language: Counted(report) for report in found.reports}


def spoken(corpus: str, word: str) -> tuple[int, int]:
    """Return how often a word stands in a corpus, and the number of all words."""
    text = " ".join(line.text for line in corpora()[corpus]).casefold()
    words = re.findall(r"[a-z']+", text)
    return words.count(word), len(words)


def percent(value: float, digits: int = 1) -> str:
    """Return a percentage."""
    return f"{value:.{digits}f} %"


# Tables


@cache
def mapping(language: str) -> Mapping[str, str]:
    """Map each phoneme of Table 1 to the common phoneme that banks draw."""
    library = Library(project=None)
    shades = library.common().model.shades
    table_ = library.language(language).model.notations["sapi"]
    names = {phoneme: " ".join(table_[phoneme].to) for phoneme in PAPER["table_1"]}
    return {one: shades[name].like if name in shades else name for one, name in names.items()}


def table_1() -> str:
    """Set Table 1 beside the mappings of the packs."""
    rows = [
        [
            phoneme, row["example"], row["common"],
            *(f"**{own}**" if own != row["common"] else own
              for own in (mapping(language)[phoneme] for language in reversed(MAPPINGS))),
        ]
        for phoneme, row in PAPER["table_1"].items()
    ]  # fmt: skip
    head = ["phoneme", "example", "Table 1", *(f"`{name}`" for name in reversed(MAPPINGS))]
    return table(head, rows)


# Coverage


def needs(corpus: str) -> list[int]:
    """Return the number of unique bigrams of each line, with those of silence at its ends."""
    read = transcribe([line.text for line in corpora()[corpus]], "paper-english")
    return [len({*pairwise(("", *one.phonemes, ""))}) for one in read]


def _both(corpus: str, cell: Callable[[Counted], str]) -> str:
    """Return a cell with both mappings, or with one figure where they agree."""
    return " / ".join(dict.fromkeys(cell(one) for one in counted(corpus).values()))


def figures() -> str:
    """Set the counts beside those of the paper."""
    pairs = len(counted("all")["english"].counts) + counted("all")["english"].unused
    printed = [*PAPER["table_2"].values()]
    usual, never = PAPER["most_common"], PAPER["never_used"]
    hours = (pairs - never) * PAPER["minutes"] / MINUTES_OF_AN_HOUR
    rows: Iterable[tuple[str, str, Callable[[Counted], str]]] = [
        ("bigrams as they occur", "not stated", lambda one: f"{one.total:,}"),
        ("most frequent phoneme", "`d`", Counted.most_frequent),
        (
            f"never used, of {pairs}",
            f"{never} ({percent(100 * never / pairs)})",
            lambda one: f"{one.unused} ({percent(100 * one.unused / pairs)})",
        ),
        ("bigrams for 90 %", "not stated", lambda one: str(one.needed(90))),
        (
            "bigrams for 99 %",
            f"about {usual['bigrams']} ({usual['percent']} %)",
            lambda one: str(one.needed(99)),
        ),
        (
            f"share of the first {usual['bigrams']}",
            f"{usual['percent']} %",
            lambda one: percent(one.first(usual["bigrams"])),
        ),
        (
            f"share of the first {len(printed)}",
            percent(sum(printed)),
            lambda one: percent(one.first(len(printed))),
        ),
        ("hours to draw all that occur", f"{hours:.1f}", lambda one: f"{one.hours:.1f}"),
    ]
    utterances = ["utterances", "about 200", *(str(len(lines)) for lines in corpora().values())]
    body = [[name, paper, *(_both(one, cell) for one in corpora())] for name, paper, cell in rows]
    return table(["default / Table 1", "paper", *corpora()], [utterances, *body])


def unused() -> str:
    """Tell how the number of unused bigrams falls with the corpus."""
    fewer, more = ({n: c.unused for n, c in counted(name).items()} for name in ("sentences", "all"))
    excess = [
        one.unused - PAPER["never_used"]
        for name in ("sentences", "mixed")
        for one in counted(name).values()
    ]
    return (
        f"The number of unused bigrams falls as the corpus grows. With the default mapping it is {fewer['english']} after "
        f"{len(corpora()['sentences'])} sentences, and {more['english']} after {len(corpora()['all'])}. With Table 1 it is "
        f"{fewer['paper-english']}, and then {more['paper-english']}. Corpora of 200 utterances leave {min(excess)} to "
        f"{max(excess)} more unused than the paper's."
    )


def table_2() -> str:
    """Set Table 2 beside the counts with both mappings."""
    counts = [
        (f"{corpus}, {MAPPINGS[name]}", one)
        for corpus in ("sentences", "mixed")
        for name, one in counted(corpus).items()
    ]
    head = ["rank", "bigram", "paper", *(title for title, _ in counts)]
    rows = [
        [str(rank), bigram, f"{printed:.2f}", *(f"{one.percent(bigram):.2f}" for _, one in counts)]
        for rank, (bigram, printed) in enumerate(PAPER["table_2"].items(), 1)
    ]
    return table(head, rows)


def likeness() -> str:
    """Compare each count with Table 2."""
    rows = [
        [corpus, MAPPINGS[name], f"{shared} of {len(PAPER['table_2'])}", f"{mean:.2f}", f"{r:.2f}"]
        for corpus in ("sentences", "mixed", "dialogue", "all")
        for name, one in counted(corpus).items()
        for shared, mean, r in [one.likeness()]
    ]
    head = ["corpus", "mapping", "among our first 21", "mean difference, points", "Pearson's r"]
    return table(head, rows)


def largest() -> str:
    """Explain the largest differences from Table 2."""
    sentences, dialogue = (counted(one)["paper-english"] for one in ("sentences", "dialogue"))
    mixed, default = (counted("mixed")[one] for one in ("paper-english", "english"))
    (the, words), (few, others) = spoken("sentences", "the"), spoken("dialogue", "the")
    printed = PAPER["table_2"]
    return "\n".join(
        [
            (
                f'- `th-ah` is "the": {the} of the {words:,} words of the sentences, and {few} of the {others} words of the '
                f"dialogue. In the dialogue alone it is {percent(dialogue.percent('th-ah'), 2)}, beside the paper's "
                f"{printed['th-ah']:.2f}."
            ),
            (
                f'- `ah-d` has the vowel of "cat" and the n of "sing" in Table 1, and not in the default mapping. In the mixed '
                f"corpus it is {percent(mixed.percent('ah-d'), 2)} with Table 1, and {percent(default.percent('ah-d'), 2)} with the "
                f"default; the paper has {printed['ah-d']:.2f}."
            ),
            (
                f'- `ih-w` is rare in our corpora: {percent(mixed.percent("ih-w"), 2)} of the mixed one. `sh-w`, the word "you", is '
                f'{percent(mixed.percent("sh-w"), 2)} there, because Table 1 sends "y" to `sh`. An engine that writes '
                'the "y" of "you" as a short vowel makes `ih-w` of it. We guess that the paper\'s engine did so.'
            ),
            (
                f'- `ah-r` is "er" written as a schwa and an "r": {printed["ah-r"]:.2f} % in the paper, and '
                f"{percent(sentences.percent('ah-r'), 2)} of the sentences. eSpeak NG writes one sound, which maps to `er`."
            ),
            (
                f"- `d-ih`, `ih-kg` and `s-ih` are rarer in our corpora: {percent(mixed.percent('d-ih'), 2)} of the mixed one "
                f"is `d-ih`. eSpeak NG reads unstressed vowels as a schwa, which maps to `ah`. This too is a guess about the "
                "other engine."
            ),
        ]
    )


def cover() -> str:
    """Tell how many lines the greedy cover takes."""
    report = counted("all")["english"].report
    return f"- The {report.lines} sentences need {len(report.sentences)} for their {len(report.bigrams)} bigrams of the default mapping."


# The items


def _departures() -> str:
    """Tell which phonemes the default has elsewhere than Table 1."""
    own = mapping("english")
    rows = ((row, own[one]) for one, row in PAPER["table_1"].items())
    told = (f'"{row["example"]}" is `{name}`' for row, name in rows if name != row["common"])
    return f"default: {' and '.join(told)}"


def _agreeing(language: str) -> str:
    """Count the phonemes that a mapping has as Table 1."""
    own, rows = mapping(language), PAPER["table_1"]
    return f"{sum(own[one] == row['common'] for one, row in rows.items())} of {len(rows)}"


def _articulation(method: str) -> str:
    """Return the r of the aperture of a method, which `docs/measure.py` measured."""
    return f"{fmean(MEASURED['articulation']['figures']['r']['aperture'][method]):.2f}"


def _shut(part: str) -> str:
    """Return the share of vowels beside labials that stay shut."""
    return percent(MEASURED[part]["figures"]["posesets"][FACE]["shut %"], 0)


@cache
def computed() -> SimpleNamespace:
    """Return the figures that items name."""
    library = Library(project=None)
    face, common = library.poseset(FACE).model, library.common().model
    mixed = counted("mixed")
    paper, default = mixed["paper-english"], mixed["english"]
    pairs = paper.unused + len(paper.counts)
    constraints = face.constraints
    opening = [one for one in constraints.pairs if one.paper and one.paper < constraints.default]
    needed = needs("sentences")
    usual, minutes = PAPER["most_common"]["bigrams"], PAPER["minutes"]
    left = (pairs - PAPER["never_used"]) * minutes / MINUTES_OF_AN_HOUR
    study = (PAPER["choices"] * (row["difference"] / 100) ** 2 for row in PAPER["study"].values())
    tags = [library.language(one.name).model.tag for one in library.names("language")]
    return SimpleNamespace(
        languages=sum("-x-" not in tag for tag in tags),
        posesets=len({one.name for one in library.names("poseset")}),
        own=_articulation("drafted bank"), linear=_articulation("linear warp"),
        keyframes=_articulation("keyframes at centres"), crossfade=_articulation("cross-fade"),
        dominance=_articulation("dominance, utterance"),
        table_1=_agreeing("paper-english"), table_1_default=_agreeing("english"),
        departs=_departures(), phonemes=len(common.base), pairs=pairs,
        silent=2 * len(common.base), poses=len(face.poses),
        reduced=percent(100 * pairs / len(PAPER["table_1"]) ** 2),
        r_paper=f"{paper.likeness()[2]:.2f}", r_default=f"{default.likeness()[2]:.2f}",
        most=paper.most_frequent(), most_default=default.most_frequent(),
        unused=paper.unused, unused_default=default.unused,
        first=percent(paper.first(usual)), first_default=percent(default.first(usual)),
        thresholds=", ".join(f"{one.paper:g}" for one in opening),
        thresholds_default=", ".join(f"{one.threshold:g}" for one in opening),
        others=len(constraints.pairs) - len(opening),
        shut=_shut("motion"), shut_paper=_shut("motion-paper"),
        priority=" < ".join(f"`{pose}`" for pose in face.priority),
        chi=", ".join(f"{one:.2f}" for one in study),
        minutes=f"{pairs * minutes:,}", hours=f"{pairs * minutes / MINUTES_OF_AN_HOUR:g}",
        hours_left=f"{left:.1f}", needs=f"{min(needed)} to {max(needed)}",
        added=compile_pair(library, "mandarin", FACE).report.extra,
        triples=f"{len(common.base) ** 3:,}", shades=len(common.shades),
    )  # fmt: skip


def filled(text: str) -> str:
    """Return a text of an item with its figures."""
    return text.format(f=computed(), paper=PRESETS["paper"], default=PRESETS["default"])


def items() -> str:
    """List the items of the paper by its sections."""
    parts = [f"The list has {sum(len(one['items']) for one in ITEMS)} items."]
    head = ["the paper", "here", "see it", "difference"]
    for one in ITEMS:
        rows = []
        for item in one["items"]:
            shown = [f"`{item['see']}`"] if "see" in item else []
            shown += [f"`out/paper/{item['file']}`"] if "file" in item else []
            differs = filled(item.get("differs", ""))
            rows.append([item["says"], filled(item["here"]), "; ".join(shown), differs])
        parts += [f"## {one['title']}", table(head, rows)]
    return "\n\n".join(parts)


BLOCKS = {one.__name__: one for one in (figures, unused, table_2, likeness, largest, cover, items)}
"""Writers of the generated parts, by the names of their marks."""


def page(path: Path) -> str:
    """Return a page with its marked parts generated again."""
    return written(path.read_text("utf-8"), lambda name: BLOCKS[name]())


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(page(path), encoding="utf-8")
        sys.stdout.write(f"{path}\n")
