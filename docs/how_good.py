# ruff: noqa: E501 - lines of the page
"""Write the tables and pictures of `docs/explanation/how-good-is-it.md` from kept figures.

    python docs/how_good.py [--no-pictures]

Figures are those of `docs/measured.json`, which `docs/measure.py` measures, and of
`docs/published.yaml`, which names their sources. Text between the marks `made: NAME` and `end` is
generated; all other text of the page is written by hand, and states no figure.
`tests/docs/test_how_good.py` generates the page again and compares.
"""

import argparse
import json
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from statistics import mean, median
from typing import Any

from lipsync_lang.packs.yaml.events import load_yaml

DOCS = Path(__file__).parent
PAGE = DOCS / "explanation" / "how-good-is-it.md"
MEASURED, PUBLISHED = DOCS / "measured.json", DOCS / "published.yaml"
MARKED = re.compile(r"(<!-- made: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)

Figures = Mapping[str, Any]

RATES = ("12", "24", "30", "60", "120")
"""Frame rates of the table of contacts."""

METHODS = (
    ("drafted bank", "this program: drafts, default motion"),
    ("paper's motion", "the same drafts, the paper's motion"),
    ("linear warp", "default motion, even stretching"),
    ("keyframes at centres", "keyframes at the sounds' centres"),
    ("dominance, utterance", "dominance over the utterance"),
)
MEASURES = (("aperture", "aperture"), ("protrusion", "protrusion"), ("tongue_tip", "tongue tip"))
CLOSURES = {
    "nasal": "the closure of a nasal",
    "inside": "the closure of a stop inside speech",
    "first": "the release of a stop after a pause",
    "last": "the closure of a stop before a pause",
}
"""Kinds of lip closures, and the moments that judge them (`benchmarks/closures.py`)."""

MOST_APART = 4
"""Number of phonemes that are named as farthest from film."""

MOTIONS = (
    ("> 8 Hz %", "power above 8 Hz, %"),
    ("still %", "still while open, %"),
    ("speed", "speed, 95 %, 1/s"),
    ("jerk e4", "jerk, 95 %, 1e4/s³"),
    ("extrema", "turns a second"),
    ("shut %", "vowels beside labials shut, %"),
)
SPEEDS = (
    ("utterance: 40 phonemes", "an utterance of 40 phonemes"),
    ("utterance: 2,560 phonemes", "an utterance of 2,560 phonemes"),
    ("batch: each of 1,000, perform_many", "each of 1,000 utterances at once"),
    ("hour: 43,373 phonemes", "an hour of speech as one utterance"),
    ("stream: phoneme known a second ahead: median", "a frame of a stream, median"),
    ("resolve: new process, warm cache", "a language on a character, warm cache"),
    ("start: run, 120 timed phonemes to CSV", "a whole command, timed phonemes to CSV"),
    (
        "build: 10,000 lines, cold, 2 workers, estimated",
        "10,000 timed lines to CSV and GLB, two workers, estimated",
    ),
)


NUMBER = re.compile(r"([-+]?[\d.,]+(-[\d.]+)?( (%|us|ms|s))?( \([\w-]+\))?)?")
"""Cells that are aligned to the right."""


# Markdown


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table; numbers stand at the right."""
    rows = list(rows)
    marks = [
        "---:" if rows and all(NUMBER.fullmatch(row[n]) for row in rows) else "---"
        for n in range(len(head))
    ]
    return "\n".join("| " + " | ".join(line) + " |" for line in [list(head), marks, *rows])


def percent(share: float, digits: int = 0) -> str:
    """Return a share as a percentage."""
    return f"{100 * share:.{digits}f} %"


def picture(name: str, alternative: str) -> str:
    """Return a picture."""
    return f"![{alternative}](../images/how-good-{name}.png)"


def measured_by(part: Figures) -> str:
    """Return the line that says how and on what a table was measured."""
    return (
        f"*Measured {part['date']} by [`{part['benchmark']}`](../../{part['benchmark']}), on "
        f"{part['inputs']}.*"
    )


class Page:
    """The parts of the page, made of figures that were measured and published."""

    def __init__(self, measured: Figures, published: Figures) -> None:
        self.measured, self.published = measured, published
        self.here = published["elsewhere"]

    def figures(self, name: str) -> Any:
        """Return the figures of a part."""
        return self.measured[name]["figures"]

    def block(self, name: str) -> str:
        """Return the text between two marks."""
        return str(getattr(self, name)()).strip()

    def joined(self, name: str, *texts: str) -> str:
        """Return texts, the peers of a part, and what was not found."""
        return "\n\n".join(text for text in (*texts, self.peers(name)) if text)

    def peers(self, name: str) -> str:
        """Return what others published."""
        rows = [
            [peer["who"], peer["figure"], peer["of"], peer["data"], f"[{number}](#sources)"]
            for number, peer in enumerate(self.published["peers"], 1)
            if peer["part"] == name
        ]
        head = ["published elsewhere", "figure", "of", "on", "source"]
        missing = self.published["unknown"][name]
        return "\n\n".join(text for text in (rows and table(head, rows), missing) if text)

    def sources(self) -> str:
        """Return the sources of what others published."""
        return "\n".join(
            f"{number}. {peer['source']}: [{peer['read']}]({peer['url']}), looked up "
            f"{peer['looked_up']}."
            for number, peer in enumerate(self.published["peers"], 1)
        )

    # Parts

    def means(self) -> dict[str, dict[str, float]]:
        """Return the mean r of the recordings, by measure and method."""
        return {
            measure: {method: mean(values) for method, values in methods.items()}
            for measure, methods in self.figures("articulation")["r"].items()
        }

    def articulation(self) -> str:
        """Return r by method, on the shipped benchmark and on held-out voices."""
        found = self.means()
        rows = [
            [title, *(f"{found[measure][method]:.2f}" for measure, _ in MEASURES)]
            for method, title in METHODS
        ]
        each = self.figures("articulation")["r"]
        spread = ", ".join(
            f"{title} {min(each[measure]['drafted bank']):.2f} to "
            f"{max(each[measure]['drafted bank']):.2f}"
            for measure, title in MEASURES
            if "drafted bank" in each[measure]
        )
        held = [
            [name, *(f"{value:.2f}" for value in values)] for name, *values in self.here["held_out"]
        ]
        names = [title for _, title in MEASURES]
        return self.joined(
            "articulation",
            picture("articulation", self.articulation_words()),
            table(["r, mean of the recordings", *names], rows),
            measured_by(self.measured["articulation"])
            + f" The default varies from recording to recording: {spread}.",
            f"On {self.here['voices']}:",
            table(["r, mean of the voices", *names], held),
            f"*{self.here['about']} {self.here['held_out_note']}*",
        )

    def articulation_words(self) -> str:
        """Return the picture of articulation in words."""
        found = self.means()
        told = "; ".join(
            f"{title} {found[measure]['drafted bank']:.2f} by the default, "
            f"{found[measure]['paper' + chr(39) + 's motion']:.2f} by the paper's motion, "
            f"{found[measure]['keyframes at centres']:.2f} by keyframes, "
            f"{found[measure]['dominance, utterance']:.2f} by dominance"
            for measure, title in MEASURES
        )
        return f"Bars of Pearson's r with real mouths: {told}"

    def front(self) -> str:
        """Return r with speakers that nothing was tuned on, and what another person reaches."""
        rows = [
            [
                name,
                *(
                    "" if value is None else value if isinstance(value, str) else f"{value:.2f}"
                    for value in values
                ),
            ]
            for name, *values in self.here["front"]
        ]
        voices = " ".join(self.here["front_voices"].split())
        return "\n\n".join(
            [
                f"On {voices}:",
                table(["r, mean of the speakers", *self.here["front_head"]], rows),
                f"*{self.here['about']}*",
            ]
        )

    def mouths(self) -> str:
        """Return how heads open and narrow on their meshes, beside film."""
        found = self.figures("mouths")
        rows = [
            [
                f"{row['head']}, {row['poseset']}" if "poseset" in row else f"**{row['head']}**",
                *(f"{row[key]:.2f}" if key in row else "" for key in ("aperture r", "width r")),
                f"{row['aperture 95 %']:.2f}",
                f"{row['width 5 %']:+.2f} to {row['width 95 %']:+.2f}",
                f"{row['aperture SD']:.3f} / {row['width SD']:.3f}",
            ]
            for row in found["rows"]
        ]
        head = [
            "head, pose set",
            "aperture r",
            "width r",
            "aperture, 95 %",
            "width, 5 to 95 %",
            "SD",
        ]
        apart = [
            f"{name}: " + ", ".join(f"{sound} {more:+.2f}" for sound, more in self.apart(sounds))
            for name, sounds in found["apertures"].items()
        ]
        return "\n\n".join(
            [
                table(head, rows),
                f"Apertures at the middle of a sound that are farthest from film: {'; '.join(apart)}.",
                measured_by(self.measured["mouths"])
                + f" Filmed lips are {found['ahead']:.2f} s ahead of their sound, and are compared there.",
            ]
        )

    @staticmethod
    def apart(sounds: Mapping[str, Sequence[float]]) -> list[tuple[str, float]]:
        """Return the phonemes whose apertures differ most, with our aperture less that of film."""
        more = {name: ours - film for name, (ours, film) in sounds.items()}
        return sorted(more.items(), key=lambda one: -abs(one[1]))[:MOST_APART]

    def motion(self) -> str:
        """Return how the jaw moves, beside captures."""
        ours, papers = self.figures("motion")["posesets"], self.figures("motion-paper")["posesets"]
        rows = [
            [
                title,
                "-".join(f"{edge:g}" for edge in dict.fromkeys(self.here["captures"][key])),
                *(f"{ours[poseset][key]:.1f}" for poseset in ours),
                f"{papers['facefx'][key]:.1f}",
            ]
            for key, title in MOTIONS
        ]
        head = ["jaw", "captures", *ours, "the paper's motion, facefx"]
        words = "; ".join(
            f"{row[0]}: captures {row[1]}, default {row[2]}, the paper's motion {row[-1]}"
            for row in rows
        )
        return self.joined(
            "motion",
            picture("motion", f"Each measure of the jaw beside the range of captures. {words}"),
            table(head, rows),
            measured_by(self.measured["motion"])
            + f" The column of captures shows {self.here['captures_of']}. {self.here['about']}",
        )

    def contacts(self) -> str:
        """Return contacts missed, by frame rate and language."""
        ways = (("this program", "motion"), ("the paper's motion", "motion-paper"))
        rows = []
        for title, part in ways:
            one = self.figures(part)["posesets"]["facefx"]
            counts = [f"{one['missed'][rate + '.0' if rate + '.0' in one['missed'] else rate]}"
                      for rate in RATES]  # fmt: skip
            rows.append([f"{title}, of {one['contacts']}", *counts])
        spoken, failed = self.performed()
        total = sum(row["contacts"] for row in spoken.values())
        worst = {
            way: sum(max(row[way].values()) for row in spoken.values())
            for way in ("default", "paper")
        }
        return self.joined(
            "contacts",
            table(["missed at frames a second", *RATES], rows),
            measured_by(self.measured["motion"]),
            f"In {len(spoken)} languages, {total:,} contacts, each language at its worst frame rate: "
            f"{worst['default']} missed by this program ({percent(worst['default'] / total, 1)}), "
            f"{worst['paper']:,} by the paper's motion ({percent(worst['paper'] / total)})."
            + (f" Lines of {', '.join(failed)} could not be spoken." if failed else ""),
            measured_by(self.measured["languages"]),
        )

    def performed(self) -> tuple[dict[str, Figures], list[str]]:
        """Return the languages whose texts were performed, and those that failed."""
        spoken = self.figures("languages")["languages"]
        failed = [name for name, row in spoken.items() if row.get("failed")]
        return {name: row for name, row in spoken.items() if name not in failed}, failed

    def coverage(self) -> str:
        """Return the data for texts and for pictures."""
        spoken = self.figures("languages")["languages"]
        used = {name: row["used"] for name, row in spoken.items()}
        ninety = [row["for_90"] for row in spoken.values()]
        words = sum(row["words"] for row in spoken.values())
        lost = sum(row["lost"] for row in spoken.values())
        gaps = sum(row["gaps"] for row in spoken.values())
        drafted = mean(row["drafted"] for row in spoken.values())
        low, high = min(used, key=lambda name: used[name]), max(used, key=lambda name: used[name])
        rows = [
            ["languages read", f"{len(spoken)}"],
            ["words read", f"{words:,}"],
            ["words and labels that no engine reads and no pack maps", f"{lost:,}"],
            ["bigrams of 441 that a text uses, least", f"{used[low]} ({low})"],
            ["the same, median", f"{median(used.values()):g}"],
            ["the same, most", f"{used[high]} ({high})"],
            ["bigrams for 90 % of the spoken text, median", f"{median(ninety):g}"],
            ["bigrams without any curve", f"{gaps}"],
            ["share of drafts in the spoken text", percent(drafted)],
        ]
        picture_words = (
            f"A bar for each of {len(spoken)} languages: bigrams that its text uses, from {used[low]} in "
            f"{low} to {used[high]} in {high}, and the {min(ninety)} to {max(ninety)} of them that are 90 % "
            "of the spoken text"
        )
        return self.joined(
            "coverage",
            table([f"on {self.figures('languages')['character']}", ""], rows),
            measured_by(self.measured["languages"]),
            picture("coverage", picture_words),
            self.by_language(),
            self.segments(),
        )

    def by_language(self) -> str:
        """Return a table of all languages, which a reader opens."""
        rows = [
            [name, f"{row['words']:,}", f"{row['used']}", f"{row['for_90']}",
             percent(row["drafted"]), f"{row['lost']}", f"{row['contacts']}",
             f"{max(row['default'].values())}", f"{max(row['paper'].values())}"]
            for name, row in sorted(self.figures("languages")["languages"].items())
        ]  # fmt: skip
        head = [
            "language", "words", "bigrams used", "for 90 %", "drafted", "not read", "contacts",
            "missed", "by the paper's motion",
        ]  # fmt: skip
        opened = "<details>\n<summary>All languages</summary>"
        return f"{opened}\n\n{table(head, rows)}\n\n</details>"

    def segments(self) -> str:
        """Return how many sounds of the world's languages find a mouth."""
        found = self.figures("segments")["segments"]
        return (
            f"{found['resolved']:,} of {found['segments']:,} segments of the IPA find a mouth shape by their "
            f"features, {found['exact']:,} without any loss. {measured_by(self.measured['segments'])}"
        )

    def reading(self) -> str:
        """Return errors of reading by language."""
        found = self.figures("reading")["languages"]
        order = sorted(found, key=lambda name: found[name]["error"])
        rows = [
            [name, f"{found[name]['words']:,}", percent(found[name]["error"], 1),
             *(percent(found[name][key], 1) for key in ("closures", "rounding")),
             " / ".join(percent(one, 1) for one in found[name].get("allowed", {}).values())]
            for name in order
        ]  # fmt: skip
        middle = median(row["error"] for row in found.values())
        words = ", ".join(f"{name} {percent(found[name]['error'])}" for name in order)
        return self.joined(
            "reading",
            f"The median error of {len(found)} lists is {percent(middle, 1)} of the phonemes. The worst list, {order[-1]}, has "
            f"{percent(found[order[-1]]['error'])}.",
            picture("reading", f"Bars of phoneme error by language: {words}"),
            table(
                [
                    "language",
                    "words",
                    "phoneme error",
                    "wrong lip closure",
                    "wrong rounding",
                    "all three, conventions allowed",
                ],
                rows,
            ),
            measured_by(self.measured["reading"])
            + " The lists follow their own conventions, and a difference of convention counts as an error: "
            + f"{self.two_lists()}. Khmer's list writes j as y, and the French one has weak vowels that may be left out. "
            + "The last column allows such conventions, which [`dictionaries.yaml`](../../benchmarks/dictionaries.yaml) states. "
            + "Closures and rounding are shares of the words. The British list was left out, because it looks like the work of eSpeak NG "
            "itself. The project does not record which words helped to write the packs.",
        )

    def two_lists(self) -> str:
        """Return the errors of one language against two lists."""
        found = self.figures("reading")["languages"]
        named = [name for name in found if "." in name]
        return "; ".join(
            f"{name.partition('.')[0]} has {percent(found[name]['error'])} by {name.partition('.')[2]}, and "
            f"{percent(found[name.partition('.')[0]]['error'])} by the other list"
            for name in named
        )

    def alignment(self) -> str:
        """Return errors of boundaries."""
        rows = []
        for title, one in self.aligned():
            rows.append(
                [title, f"{one['boundaries']:,}", f"{one['median_ms']:.0f}", f"{one['mean_ms']:.0f}",
                 f"{one['p90_ms']:.0f}", f"{one['late_ms']:+.0f}", percent(one["within_ms"]["20"]),
                 percent(one["within_ms"]["30"])]
            )  # fmt: skip
        head = ["sound and text", "boundaries", "median, ms", "mean", "90 %", "late", "within 20 ms", "30 ms"]  # fmt: skip
        told = self.figures("hearing")["texts"]
        doubts = [
            [kind, f"{one['texts']}", percent(one["remarked_on"])] for kind, one in told.items()
        ]
        words = "; ".join(
            f"{row[0]}: half within {row[2]} ms, 90 % within {row[4]}" for row in rows
        )
        lips = [
            [
                title,
                CLOSURES[place],
                f"{one['closures']}",
                f"{one['median_ms']:.0f}",
                percent(one["off"]),
            ]
            for title, part in self.aligned()
            if not title.startswith(("eSpeak", "the same"))
            for place, one in part["places"].items()
        ]
        return self.joined(
            "alignment",
            picture("alignment", f"Share of boundaries within each error. {words}"),
            table(head, rows),
            measured_by(self.measured["alignment"])
            + " "
            + measured_by(self.measured["hearing"])
            + " "
            + measured_by(self.measured["warping"])
            + " The labels of CMU ARCTIC were made by another aligner.",
            table(
                [
                    "sound and text",
                    "lip closures, judged by",
                    "number",
                    "median, ms",
                    "off by over 33 ms",
                ],
                lips,
            ),
            "A stop is silent between its closure and its release. After a pause the release is judged, and elsewhere "
            "the closure. A nasal sounds as long as the lips are closed. eSpeak NG is left out, since it states the release "
            "as the start of a stop.",
            table(["text", "number", "called doubtful by a remark"], doubts),
        )

    def aligned(self) -> list[tuple[str, Figures]]:
        """Return the sets of boundaries, with titles."""
        german = self.figures("hearing")["boundaries"]["german, all, by hand"]
        titles = {
            "spoken": "eSpeak NG, English",
            "arctic_a0009.wav": "one sentence of CMU ARCTIC",
        }
        warped = self.figures("warping")["rows"][0]
        found = [("German, by hand, three recordings", german)]
        for row in self.figures("alignment")["rows"]:
            name = titles.get(row["name"], f"eSpeak NG, {row['name']}")
            found.append((name, row))
        return [found[0], ("the same German, by warping alone", warped), *found[1:]]

    def recognition(self) -> str:
        """Return errors of recognition."""
        found = self.figures("recognition")
        words = [
            [name, f"{one['words']}", percent(one["error"])] for name, one in found["words"].items()
        ]
        sounds = [
            ["aligned with its text" if name == "(its text)" else name, language,
             f"{one['closures']}", percent(one["lost"]), percent(one["invented"]), percent(one["phonemes"])]
            for name, languages in found["sounds"].items()
            for language, one in languages.items()
        ]  # fmt: skip
        head = ["heard by", "language", "lip closures", "lost", "invented", "phonemes right"]
        return self.joined(
            "recognition",
            table(["heard by", "words", "words wrong"], words),
            table(head, sounds),
            measured_by(self.measured["recognition"])
            + " A lip closure is lost if none is heard within two frames of 60 a second. Phonemes are counted in steps "
            "of 10 ms. A recording loses closures even with its text, because the labels differ from the language's reading.",
        )

    def speed(self) -> str:
        """Return how fast things are."""
        part = self.measured["speed"]
        rows = [[title, part["figures"][key]] for key, title in SPEEDS if key in part["figures"]]
        lengths = self.lengths()
        words = ", ".join(
            f"{count:,} phonemes in {seconds * 1000:.3g} ms" for count, seconds in lengths
        )
        return self.joined(
            "speed",
            picture("speed", f"Time of an utterance by its length: {words}"),
            table(["timed phonemes to curves, and whole commands", "time"], rows),
            f"*Stated {part['date']} in [performance](../reference/performance.md), with the goals beside "
            f"them, by [`{part['benchmark']}`](../../{part['benchmark']}): {part['machine']}.*",
            self.here["smartbody"],
        )

    def lengths(self) -> list[tuple[int, float]]:
        """Return the seconds of utterances by their number of phonemes."""
        scale = {"us": 1e-6, "ms": 1e-3, "s": 1.0}
        found = []
        for key, text in self.measured["speed"]["figures"].items():
            if count := re.fullmatch(r"utterance: ([\d,]+) phonemes", key):
                value, unit = text.replace(",", "").split()
                found.append((int(count[1].replace(",", "")), float(value) * scale[unit]))
        return found

    def fitting(self) -> str:
        """Return what fits gain, where they were measured."""
        if "fitting" not in self.measured:
            return "Not measured yet."
        part = self.measured["fitting"]
        rows = []
        for poseset, measures in part["figures"]["posesets"].items():
            for measure, one in measures.items():
                gains = [
                    after - before
                    for before, after in zip(one["before"], one["after"], strict=True)
                ]
                rows.append(
                    [f"{poseset}, {measure.replace('_', ' ')}", f"{mean(one['before']):.2f}",
                     f"{mean(one['after']):.2f}", f"{min(gains):+.2f} to {max(gains):+.2f}"]
                )  # fmt: skip
        known = " ".join(
            f"Known targets were fitted again from {one['minutes']:g} minutes of a made-up face, with errors of timing and "
            f"noise, in {one['seconds']:.0f} s. The root mean square error of its {poseset} curves is "
            f"{one['before']:.3f} before and {one['after']:.3f} after."
            for poseset, one in part["figures"]["known"].items()
        )
        return self.joined(
            "fitting",
            table(["r with the recording left out", "before", "after", "by recording"], rows),
            "The fit uses the other recordings. The shipped targets have seen all of them, including the left-out "
            "one, so the column *before* has an advantage.",
            f"{known} {self.busy(part)}",
            measured_by(part),
        )

    def busy(self, part: Figures) -> str:
        """Return a remark on times that were measured beside other programs."""
        load, cores = part.get("load", 0.0), part["cores"]
        if load < cores / 2:
            return ""
        return f"The time was measured while other programs ran, with a load of {load:g} on {cores} cores."

    def fitted(self) -> str:
        """Return the fits in a few words."""
        if "fitting" not in self.measured:
            return "not measured yet"
        found = [
            one for each in self.figures("fitting")["posesets"].values() for one in each.values()
        ]
        before, after = (mean(mean(one[side]) for one in found) for side in ("before", "after"))
        return f"left-out recording: r {after:.2f} after a fit to the others, {before:.2f} before"

    def preference(self) -> str:
        """Return what studies found."""
        return self.joined("preference", "There is no study of this program yet.")

    def summary(self) -> str:
        """Return the page in one table."""
        found = self.means()
        jaw = self.figures("motion")["posesets"]["facefx"]
        missed = self.figures("motion")["posesets"]["facefx"]["missed"]
        spoken = self.figures("languages")["languages"]
        reading = self.figures("reading")["languages"]
        german = self.aligned()[0][1]
        heard = self.figures("recognition")["words"]
        best = min(heard, key=lambda name: heard[name]["error"])
        rows = [
            ["[articulation](#articulation)",
             "r " + ", ".join(f"{found[key]['drafted bank']:.2f} {title}" for key, title in MEASURES),
             "protrusion is weak; drafts were made with these three recordings"],
            ["[motion](#motion-beside-captures)",
             f"{jaw['> 8 Hz %']:.1f} % of the power above 8 Hz, still {jaw['still %']:.1f} % of the time open",
             "captures say other lines"],
            ["[contacts](#contacts)",
             f"{max(missed.values())} of {jaw['contacts']} missed at any of {len(missed)} frame rates",
             "the motion promises this result"],
            ["[coverage](#coverage)",
             f"{len(spoken)} languages with a text, {sum(row['gaps'] for row in spoken.values())} bigrams without a curve",
             f"{percent(mean(row['drafted'] for row in spoken.values()))} of the spoken text are drafts"],
            ["[reading](#reading-of-text)",
             f"median {percent(median(row['error'] for row in reading.values()), 1)} of phonemes wrong, {len({name.partition('.')[0] for name in reading})} languages",
             f"worst {percent(max(row['error'] for row in reading.values()))}"],
            ["[alignment](#alignment)",
             f"German by hand: median {german['median_ms']:.0f} ms, {percent(german['within_ms']['20'])} within 20 ms",
             f"{german['boundaries']} boundaries of three recordings"],
            ["[recognition](#recognition)",
             f"{percent(heard[best]['error'])} of words wrong by {best}", "only English, two minutes of sound"],
            ["[speed](#speed)", f"{self.figures('speed')['utterance: 40 phonemes']} for 40 phonemes",
             "some goals of builds are missed"],
            ["[fits](#fits-from-captures)",
             self.fitted(), "three recordings"],
            ["[preference](#preference)", "no study yet", "the most important figure is missing"],
        ]  # fmt: skip
        dates = sorted({part["date"] for part in self.measured.values()})
        one = self.measured["articulation"]
        return (
            table(["", "measured here", "weak point"], rows)
            + f"\n\nMeasured {' to '.join(dict.fromkeys((dates[0], dates[-1])))} with lipsync-lang {one['lipsync-lang']}, "
            f"Python {one['python']}, {one['cores']} cores."
        )


def written(text: str, block: Callable[[str], str]) -> str:
    """Return a page with its marked parts generated again."""
    return MARKED.sub(lambda mark: f"{mark[1]}{block(mark[2])}\n{mark[3]}", text)


def loaded() -> Page:
    """Read the kept figures."""
    return Page(json.loads(MEASURED.read_text("utf-8")), load_yaml(PUBLISHED.read_text("utf-8")))


def main() -> int:
    """Write the page and its pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--no-pictures", action="store_true", help="write the page alone")
    options = parser.parse_args()
    page = loaded()
    PAGE.write_text(written(PAGE.read_text("utf-8"), page.block), encoding="utf-8")
    if not options.no_pictures:
        sys.path.insert(0, str(DOCS))
        import how_good_pictures

        how_good_pictures.draw(page, DOCS / "images")
    return 0


if __name__ == "__main__":
    sys.exit(main())
