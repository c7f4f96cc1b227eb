"""Print how every language reads: speed, memory, and what of real texts is not mapped.

python benchmarks/languages.py FOLDER [--only NAME...] [--json FILE]

The folder holds, as far as they are there:

- lines.tsv, or any .tsv: a table with a column per language, whose names the packs answer to;
  `differ` counts lines that sound otherwise when they are spoken than when they are only read
- udhr/*.txt: texts named by ISO 639-3 codes, with what follows after a `_`;
- phoible_segments.tsv, or such a file beside the folder: segments of the IPA, one a line.
"""

import argparse
import csv
import os
import resource
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

import json_figures

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.library import Library
from lipsync_lang.performing.performer import Performer
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.resolver.nearest_phonemes import among_all
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.sound.speech.speaking.transcripts import Transcript

FACE = "facefx"
"""Any pose set: common phonemes are the same for all."""

GOAL_RATE, GOAL_MEMORY = 10_000, 600
SENTENCES = 1000
"""Sentences that a speed is measured over; a shorter text is read again."""

ALSO = {
    "schinese": "zh-Hans", "tchinese": "zh-Hant", "als": "sq", "amh": "am", "azj_latn": "az",
    "ben": "bn", "bul": "bg", "cat": "ca", "cmn_hans": "zh-Hans", "cmn_hant": "zh-Hant",
    "cym": "cy", "ell_monotonic": "el", "epo": "eo", "est": "et", "eus": "eu", "gle": "ga",
    "guj": "gu", "hin": "hi", "hrv": "hr", "hun": "hu", "hye": "hy", "isl": "is", "kan": "kn",
    "kat": "ka", "kaz": "kk", "khm": "khm-Khmr", "lao": "lao-Laoo", "lat": "la", "lav": "lv",
    "lit": "lt", "mal": "ml", "mar": "mr", "mkd": "mk", "mlt": "mt", "mri": "mi", "mya": "my",
    "nep": "ne", "pan": "pa", "por_BR": "pt-BR", "por_PT": "pt-PT", "quz": "qu",
    "ron_2006": "ro", "sin": "si", "slk": "sk", "slv": "sl", "srp_cyrl": "sr", "tam": "ta",
    "tel": "te", "urd": "ur",
}  # fmt: skip
"""Names of columns and texts that are no tags."""


class Row(NamedTuple):
    """Result of one text."""

    language: str
    sentences: int
    rate: float
    labels: int
    unmapped: tuple[str, ...]
    unread: tuple[str, ...]
    differ: str


def memory() -> tuple[float, float]:
    """Return the most memory used so far by this process, and by one of its children, in MB.

    A child counts what its parent has at the time it is made: look while the parent is small.
    """
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    own, child = (resource.getrusage(kind).ru_maxrss / 1024 for kind in kinds)
    return own, child


def find(library: Library, name: str) -> str:
    """Return the pack or voice that reads a text of some name."""
    for known in (ALSO.get(name, name), name.split("_", maxsplit=1)[0]):
        for asked in (known, f"espeak:{known}", f"epitran:{known}"):
            try:
                library.language(asked)
            except LipsyncError:
                continue
            try:
                next(iter(Speaker.of(asked).transcribe(["a 1"])))
            except LipsyncError:
                continue
            return asked
    return ""


def differing(performer: Performer, heard: Sequence[Transcript]) -> str:
    """Speak some lines that were read, and count those whose common phonemes differ."""
    count = 0
    for transcript in heard:
        schedule = performer.speaker.speak(transcript.text)
        numbers, _, _ = performer.common_phonemes(schedule)
        spoken = [performer.compiled.phonemes[n] for n in numbers if n]
        silence = performer.compiled.phonemes[0]
        count += spoken != [name for name in transcript.phonemes if name != silence]
    return f"{count}/{len(heard)}"


def read(language: str, lines: Sequence[str], *, timed: bool, spoken: int = 0) -> Row:
    """Read lines and time it; speak some of them too."""
    performer = resolve(language, FACE)
    speaker = performer.speaker
    heard: list[Transcript] = list(speaker.transcribe(lines))
    repeated = (list(lines) * (SENTENCES // max(len(lines), 1) + 1))[:SENTENCES]
    start = time.perf_counter()
    for _ in speaker.transcribe(repeated) if timed else ():
        pass
    seconds = time.perf_counter() - start
    return Row(
        language,
        len(lines),
        60 * len(repeated) / seconds if timed else 0.0,
        sum(len(t.labels) for t in heard),
        tuple(dict.fromkeys(label for t in heard for label in t.unmapped)),
        tuple(dict.fromkeys(c for t in heard for c in t.unread)),
        differing(performer, heard[:spoken]) if spoken and speaker.manner.voice else "",
    )


def report(title: str, rows: Iterator[tuple[str, Row | str]]) -> None:
    """Print a table as it comes."""
    print(f"\n{title}")
    print(
        f"  {'text':<14}{'read by':<22}{'lines':>6}{'labels':>8}{'lines/min':>11}{'differ':>8}"
        "  not mapped; not read"
    )
    for name, row in rows:
        if isinstance(row, str):
            print(f"  {name:<14}{row}")
            continue
        rate = f"{row.rate:,.0f}" if row.rate else ""
        lost = f"{' '.join(row.unmapped) or '-'}; {' '.join(row.unread) or '-'}"
        print(
            f"  {name:<14}{row.language:<22}{row.sentences:>6}{row.labels:>8}{rate:>11}"
            f"{row.differ:>8}  {lost}"
        )
        sys.stdout.flush()


def table(library: Library, path: Path, only: Sequence[str]) -> Iterator[tuple[str, Row | str]]:
    """Read every column of a table of lines."""
    with path.open(encoding="utf-8") as stream:
        lines = list(csv.DictReader(stream, delimiter="\t"))
    for name in lines[0]:
        language = "" if name in ("line_id", "speaker") else find(library, name)
        if language and (not only or name in only):
            yield name, read(language, [r[name] for r in lines if r[name]], timed=True, spoken=20)


def texts(library: Library, folder: Path, only: Sequence[str]) -> Iterator[tuple[str, Row | str]]:
    """Read every text of a folder."""
    for path in sorted(folder.glob("*.txt")):
        if only and path.stem not in only:
            continue
        language = find(library, path.stem)
        lines = [line for line in path.read_text("utf-8").splitlines() if line.strip()]
        try:
            yield path.stem, read(language, lines, timed=True) if language else "nothing reads it"
        except LipsyncError as error:
            yield path.stem, f"{language}: {str(error)[:100]}"


def segments(library: Library, path: Path) -> dict[str, float]:
    """Map every segment of a table by its features, and count what became of them."""
    names = [line.split("\t")[0] for line in path.read_text("utf-8").splitlines()[1:]]
    among = among_all(library)
    start = time.perf_counter()
    found = [among.nearest(name) for name in names]
    seconds = time.perf_counter() - start
    losses = Counter(loss for near in found for loss in near.losses)
    exact = sum(not near.losses and not near.distance for near in found)
    print(f"\n{len(names)} segments by their features: {seconds * 1e6 / len(names):.0f} us each")
    resolved = sum(not n.unknown for n in found)
    print(f"  resolved {resolved}, without any loss {exact}")
    print(f"  of nothing that shows (tones): {sum(not near.value for near in found)}")
    print("  lost: " + ", ".join(f"{loss} {count}" for loss, count in losses.most_common(12)))
    return {"segments": len(names), "resolved": resolved, "exact": exact}


def main() -> None:
    """Read what the folder has."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", default=[])
    json_figures.add_option(parser)
    options = parser.parse_args()
    library = Library()
    list(Speaker.of("english").transcribe(["Hello, world"]))
    _, child = memory()
    rates: dict[str, float] = {}
    figures: dict[str, object] = {"rates": rates}

    def kept(rows: Iterator[tuple[str, Row | str]]) -> Iterator[tuple[str, Row | str]]:
        for name, row in rows:
            if isinstance(row, Row) and row.rate:
                rates[name] = row.rate
            yield name, row

    for path in sorted(options.folder.glob("*lines*.tsv")):
        report(path.name, kept(table(library, path, options.only)))
    if (options.folder / "udhr").is_dir():
        report("udhr", kept(texts(library, options.folder / "udhr", options.only)))
    for folder in (options.folder, options.folder.parent / "phonology"):
        if (folder / "phoible_segments.tsv").is_file():
            figures["segments"] = segments(library, folder / "phoible_segments.tsv")
    if rates:
        slowest = min(rates, key=lambda name: rates[name])
        print(f"\nslowest: {slowest}, {rates[slowest]:,.0f} lines a minute (goal {GOAL_RATE:,})")
    own, _ = memory()
    print(f"most memory: {own + child:.0f} MB, {child:.0f} of them eSpeak's (goal {GOAL_MEMORY})")
    json_figures.write_figures(options.json, figures)


if __name__ == "__main__":
    main()
