"""Make the paper's tables, figures and numbers again, into a folder: `make paper`.

    python docs/draw_paper.py [FOLDER] [--clips]

`README.md` of the folder lists each file beside the item of the paper that it repeats, with the
command that made it. Pictures need the extras `plot` and `speech`. The study has the paper's design
and counts; `--clips` also renders a study of two characters, which takes minutes.
"""

import argparse
import json
import shlex
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import BytesIO, StringIO
from itertools import cycle
from os.path import relpath
from pathlib import Path
from random import Random
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

import the_paper
from how_good import table

import lipsync_lang as ll
from lipsync_lang.cli import main as run_program
from lipsync_lang.performing.performer import PerformedLine
from lipsync_lang.render.plot import THIN, View, draw

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LANGUAGE, FACE = "paper-english", the_paper.FACE
LINE = "Please buy five more maps."
"""The line of figures 6 to 10; the paper does not say its own."""

FPS = 240
"""Frames per second of figures 6 to 10, for smooth lines."""

POSE = "open"
"""The pose whose curves figures 6 to 10 show."""

STEPS = (
    ("6", "stitch", "", ""),
    ("7", "stitch", "", "#2060d0"),
    ("8", "smooth", "#2060d0", "#d8b400"),
    ("9", "constrain", "#d8b400", "#00b4c8"),
    ("10", "limit", "#00b4c8", "#c020a0"),
)
"""Figures of the runtime: number, stage, and the paper's colours before and after it."""

BIGRAM_INK = {"6": "#d03030", "7": "#40a040"}
"""Colours of the bigrams' own curves, in the figures that have them."""

STRONGEST = 5
"""The strongest preference."""


class Item(NamedTuple):
    """A file of the folder."""

    name: str
    what: str
    command: str


class Maker:
    """A folder with the paper's items."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.items: list[Item] = []
        folder.mkdir(parents=True, exist_ok=True)

    def run(self, *arguments: str) -> str:
        """Run the program, and return what it prints."""
        out, said = StringIO(), StringIO()
        with redirect_stdout(out), redirect_stderr(said):
            code = run_program(arguments)
        if code:
            raise SystemExit(f"lipsync-lang {shlex.join(arguments)}: {said.getvalue()}")
        return out.getvalue()

    def add(self, name: str, what: str, command: str = "", text: str | None = None) -> Path:
        """List a file, with its text if it is one; return its path."""
        self.items.append(Item(name, what, command))
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if text is not None:
            path.write_text(f"{text.strip()}\n", encoding="utf-8")
        return path

    def told(self, name: str, what: str, *commands: Sequence[str]) -> None:
        """Write what commands print into a file."""
        parts = [f"$ lipsync-lang {shlex.join(one)}\n{self.run(*one).strip()}" for one in commands]
        self.add(name, what, f"lipsync-lang {shlex.join(commands[0])}", "\n\n".join(parts))

    def picture(
        self, name: str, what: str, page: "Callable[[], Figure]", command: str = ""
    ) -> None:
        """Draw a picture into a file."""
        out = BytesIO()
        draw(page, out, "png")
        self.add(name, what, command).write_bytes(out.getvalue())

    def index(self) -> None:
        """Write the list of all files."""
        rows = [
            [f"[{one.name}]({one.name})", one.what, f"`{one.command}`" if one.command else ""]
            for one in self.items
        ]
        text = f"# The paper's items\n\n{table(['file', 'item', 'command'], rows)}\n"
        (self.folder / "README.md").write_text(text, encoding="utf-8")


# Tables, and the figures about bigrams


def tables(maker: Maker) -> None:
    """Write Table 1 and Table 2 beside the packs as they are."""
    maker.told("table-1.txt", "Table 1, as the pack has it", ("languages", "show", LANGUAGE))
    command = "python docs/the_paper.py"
    maker.add("table-1.md", "Table 1, beside both mappings", command, the_paper.table_1())
    parts = (the_paper.figures(), the_paper.table_2(), the_paper.likeness(), the_paper.largest())
    maker.add("table-2.md", "Table 2, and the numbers of 3.1.1", command, "\n\n".join(parts))


def distribution() -> "Figure":
    """Draw the share of each bigram by its rank, as figure 2."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.add_subplot(xlabel="bigrams, by rank", ylabel="% of all bigrams")
    for name, one in the_paper.counted("mixed").items():
        shares = [100 * count / one.total for count in one.counts.values()]
        shares += [0.0] * one.unused
        axes.plot(range(1, len(shares) + 1), shares, label=f"mixed corpus, {name}")
    printed = [*the_paper.PAPER["table_2"].values()]
    axes.plot(range(1, len(printed) + 1), printed, "k.", label="the paper's Table 2")
    axes.set(xlim=(0, len(shares)), ylim=(0, None))
    axes.spines[["right", "top"]].set_visible(False)
    axes.legend(frameon=False)
    return figure


def bigrams(maker: Maker) -> None:
    """Draw figures 2 and 3."""
    maker.picture("figure-2.png", "Figure 2", distribution, "lipsync-lang coverage FILE --all")
    path = maker.folder / "figure-3.png"
    show = ("bank", "show", "f-ah", "-l", LANGUAGE, "-c", FACE, "--plot", str(path))
    maker.add("figure-3.txt", "Figure 3, its control points", "", maker.run(*show))
    shown = (*show[:-1], "figure-3.png")
    maker.add("figure-3.png", "Figure 3: F-Ah", f"lipsync-lang {shlex.join(shown)}")


# The runtime


def flow(names: Sequence[str]) -> "Figure":
    """Draw the stages of the runtime as boxes from top to bottom, as figure 5."""
    from matplotlib.figure import Figure

    steps = ["phoneme scheduler: labels and times", "bigrams, stretched over their sounds"]
    steps += [f"{name}, for each pose" for name in names] + ["poses or blend shapes of a face"]
    figure = Figure(figsize=(5, 0.8 * len(steps)))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, 1), ylim=(-len(steps) + 0.5, 0.5))
    axes.set_axis_off()
    for at, step in enumerate(steps):
        box = {"boxstyle": "round,pad=0.5", "facecolor": "#d3e7f6", "edgecolor": "#6ba6d3"}
        axes.text(0.5, -at, step, ha="center", va="center", size=11, bbox=box)
        if at:
            arrow = {"arrowstyle": "->", "color": "#333333"}
            axes.annotate("", (0.5, -at + 0.27), (0.5, -at + 0.73), arrowprops=arrow)
    return figure


def step(view: View, number: str, stage: str, before: str, after: str) -> "Figure":
    """Draw the curve of one pose before and after a stage, as figures 6 to 10."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.6), layout="constrained")
    axes = figure.add_subplot(xlim=(view.begin, view.end), ylim=(-0.3, 1))
    _sounds(axes, view)
    pose = view.animation.poses.index(POSE)
    if number in BIGRAM_INK:
        for one in range(len(view.performance.track.rows)):
            times, curves = view.performance.bigram(one, 1)
            axes.plot(times, curves[:, pose], color=BIGRAM_INK[number], lw=1.2)
    names = [one.name for one in view.stages]
    at = names.index(stage)
    for ink, which, width in ((before, at - 1, 1.2), (after, at, 2.2)):
        if ink:
            label = f"after {names[which]}"
            curve = view.stages[which].curves[pose]
            axes.plot(view.times, curve, color=ink, lw=width, label=label)
    if before or after:
        axes.legend(loc="upper right", frameon=False)
    axes.set_title(f"{POSE}: {stage if after else 'bigrams on the timeline'}", loc="left")
    return figure


def _sounds(axes: "Axes", view: View) -> None:
    """Draw the boundaries of phonemes, with their labels and common phonemes below."""
    schedule, track = view.animation.schedule, view.performance.track
    axes.vlines(track.bounds, -0.3, 1, **THIN)
    axes.axhline(0, **THIN)
    for label, start, end in zip(
        schedule.labels, schedule.times[:-1], schedule.times[1:], strict=True
    ):
        axes.text((start + end) / 2, -0.1, label, ha="center", va="center", size=9)
    phonemes = view.performer.compiled.phonemes
    for row, start, end in zip(track.ids, track.bounds[:-1], track.bounds[1:], strict=True):
        axes.text((start + end) / 2, -0.22, phonemes[row], ha="center", va="center", size=8)
    axes.set_yticks([0, 0.5, 1])
    axes.set_xlabel("seconds; phonemes, and common phonemes below", size=8)
    axes.spines[["right", "top"]].set_visible(False)


def runtime(maker: Maker) -> None:
    """Draw figures 5 to 10."""
    schedule = ll.speak(LINE, LANGUAGE)
    animation = ll.resolve(LANGUAGE, FACE).perform(schedule, fps=FPS)
    line = PerformedLine.of(animation)
    if line is None:
        raise SystemExit("the performer left no source")
    view = View(animation, line)
    used = {stage for _, stage, _, _ in STEPS}
    names = [stage.name for stage in view.stages if stage.name in used]
    command = shlex.join(("run", LINE, "-l", LANGUAGE, "-c", FACE, "--plot", "figures-6-to-10.png"))
    maker.picture("figure-5.png", "Figure 5", lambda: flow(names), f"lipsync-lang {command}")
    for one in STEPS:
        maker.picture(f"figure-{one[0]}.png", f"Figure {one[0]}", lambda one=one: step(view, *one))
    whole = maker.add("figures-6-to-10.png", "Figures 6 to 10 in one", f"lipsync-lang {command}")
    made = shlex.split(command)
    maker.run(*made[:-1], str(whole))


# The numbers of section 5


def hours() -> str:
    """Return the numbers of section 5.2, computed."""
    paper = the_paper.PAPER
    pairs = len({row["common"] for row in paper["table_1"].values()}) ** 2
    whole = pairs * paper["minutes"] / the_paper.MINUTES_OF_AN_HOUR
    kept = pairs - paper["never_used"]
    left = kept * paper["minutes"] / the_paper.MINUTES_OF_AN_HOUR
    needs = sorted(the_paper.needs("sentences"))
    rows = [
        ["bigrams", "441", str(pairs)],
        ["minutes for one", "5", str(paper["minutes"])],
        ["hours", "37.5", f"{whole:g}"],
        ["never used", "nearly 25 %", f"{100 * paper['never_used'] / pairs:.1f} %"],
        ["hours for the others", "75 %, around 3 days", f"{left:.1f} ({100 * kept / pairs:.1f} %)"],
        [
            "unique bigrams of a short sentence",
            "30-40",
            f"{needs[0]} to {needs[-1]}, median {median(needs):g}, in Harvard sentences 1 to 200",
        ],
    ]
    return table(["section 5.2", "printed", "computed"], rows)


def discussion(maker: Maker) -> None:
    """Write the numbers of sections 5.2 to 5.4."""
    maker.add("section-5.2.md", "5.2: hours of animators", "python docs/draw_paper.py", hours())
    corpus = relpath(the_paper.DOCS / "corpora" / "the-question.txt")
    maker.told(
        "section-5.2.txt", "5.2: the work that a script needs",
        ("coverage", corpus, "-l", LANGUAGE, "-c", FACE),
    )  # fmt: skip
    maker.told(
        "section-5.3.txt", "5.3: a crab's poses, and its bigrams",
        ("posesets", "show", "crab"), ("resolve", "-l", LANGUAGE, "-c", "crab"),
    )  # fmt: skip
    times = ",".join(f"{at / 10:g}" for at in range(1, 13))
    stills = ("stills", LINE, "-l", LANGUAGE, "-c", "crab", "--at", times, "-o")
    command = f"lipsync-lang {shlex.join(stills)} figure-13.png"
    sheet = maker.add("figure-13.png", "Figure 13: the crab as it speaks", command)
    maker.run(*stills, str(sheet))
    maker.told(
        "section-5.4.txt", "5.4: Mandarin, with one phoneme and 43 bigrams more",
        ("resolve", "-l", "mandarin", "-c", FACE),
    )  # fmt: skip


# The study


def strengths(mean: float, count: int, chance: Random) -> list[int]:
    """Return whole strengths from 1 to 5 that have a mean, at random."""
    drawn = [chance.randint(1, STRONGEST) for _ in range(count)]
    while missing := round(mean * count) - sum(drawn):
        at, step = chance.randrange(count), 1 if missing > 0 else -1
        drawn[at] = min(STRONGEST, max(1, drawn[at] + step))
    return drawn


def answered(paper: Mapping[str, Any]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return a study of the paper's design, and answers with its counts and strengths.

    Each character has 10 pairs, 20 raters and 200 choices. The sides of pairs alternate, and chance
    deals the choices to raters and lines: the paper does not state them.
    """
    chance = Random(1)  # noqa: S311 no secret
    methods, digest, pairs_each, raters_each = ("ours", "facefx"), "0123456789abcdef", 10, 20
    pairs = [
        {"pair": f"p{place * pairs_each + n:03}", "line": f"line_{n:02}", "character": character,
         "left": left, "right": right, "seconds": 2.0}
        for place, character in enumerate(paper["study"])
        for n, (left, right) in zip(range(pairs_each), cycle((methods, methods[::-1])))
    ]  # fmt: skip
    study = {
        "kind": "study", "format": 1, "study": digest, "title": "The paper's study", "seed": 1,
        "questions": ["accuracy"], "methods": [*methods], "raters_see": pairs_each, "pairs": pairs,
    }  # fmt: skip
    submissions = []
    for place, (character, printed) in enumerate(paper["study"].items()):
        count = paper["choices"]
        first = round(count * (1 + printed["difference"] / 100) / 2)
        told = [
            iter(strengths(mean, many, chance))
            for mean, many in zip(printed["strengths"], (first, count - first), strict=True)
        ]
        choices = [n < first for n in range(count)]
        chance.shuffle(choices)
        dealt = iter(choices)
        seen = [pair for pair in pairs if pair["character"] == character]
        for rater in range(raters_each):
            answers = []
            for pair, ours in zip(seen, dealt, strict=False):
                answers.append(
                    {"pair": pair["pair"], "question": "accuracy", "plays": 1, "seconds": 4.0,
                     "choice": "left" if ours == (pair["left"] == "ours") else "right",
                     "strength": next(told[not ours])}
                )  # fmt: skip
            submissions.append(
                {"kind": "answers", "format": 1, "study": digest, "consent": True, "asked": {},
                 "rater": f"{100 * place + rater:016x}", "started": "2013-01-05T10:00:00Z",
                 "finished": "2013-01-05T10:09:00Z", "answers": answers}
            )  # fmt: skip
    return study, submissions


def study(maker: Maker) -> None:
    """Report a study with the paper's design and counts (sections 4.1 and 4.2)."""
    asked, submissions = answered(the_paper.PAPER)
    folder = maker.add("study/study.json", "4.1: pairs", "", json.dumps(asked, indent=1)).parent
    lines = "\n".join(json.dumps(one) for one in submissions)
    maker.add("study/answers.jsonl", "4.2: answers with the printed counts", "", lines)
    report = ("study", "report", str(folder), "--one-side", "0")
    command = "lipsync-lang study report study --one-side 0"
    maker.add("study/report.txt", "4.2 and figure 12: the report", command, maker.run(*report))
    page = maker.add("study/report.html", "the report as a page", f"{command} -o report.html")
    maker.run(*report, "-o", str(page))


def clips(maker: Maker) -> None:
    """Render a study of two characters: ten pairs each, the paper's motion against keyframes."""
    made = (
        "study", "new", relpath(the_paper.DOCS / "corpora" / "the-question.txt"), "-l", LANGUAGE,
        "-c", FACE, "-c", "crab", "--method", "ours", "--method", "keyframes", "--pairs", "20",
    )  # fmt: skip
    page = maker.add(
        "clips/page.html", "4.1: a page for raters", f"lipsync-lang {shlex.join(made)}"
    )
    maker.run(*made, "-o", str(page.parent))


def main() -> int:
    """Make every item."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out/paper"))
    parser.add_argument("--clips", action="store_true", help="render a study as well")
    options = parser.parse_args()
    maker = Maker(options.folder)
    parts = (tables, bigrams, runtime, discussion, study)
    for part in (*parts, clips) if options.clips else parts:
        part(maker)
    maker.index()
    counts = Counter(Path(one.name).suffix for one in maker.items)
    sys.stdout.write(f"wrote {counts.total()} files; open {options.folder / 'README.md'}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
