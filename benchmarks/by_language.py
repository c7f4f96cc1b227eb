"""Print, for each language with a text, the bigrams that it needs and the contacts that are missed.

    python benchmarks/by_language.py FOLDER [-c facefx] [--lines N] [--only NAME...] [--json FILE]

FOLDER holds texts named as `languages.py` reads them, such as the Universal Declaration. Of each
language with a pack, one text is read:

used      bigrams of the 441 that the text uses, and how many of them are 90 % of what is spoken
drafted   share of what is spoken whose bigrams are drafts; the rest was drawn by somebody
lost      labels and words that nothing reads or maps
contacts  phonemes of the first lines that demand a contact, and how many of them are missed, at
          the worst of the frame rates of `motion.py`, by the default motion and by the paper's
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import json_figures
import motion

import languages
import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.library import Library
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.text.lines import read_lines

LINES = 8
"""Lines of a text that are performed."""


def texts(library: Library, folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield one text for each language that has a pack, by the pack's name."""
    seen = set()
    for path in sorted(folder.glob("*.txt")):
        asked = languages.find(library, path.stem)
        if asked and ":" not in asked:
            name = library.language(asked).model.name
            if name not in seen:
                seen.add(name)
                yield name, path


def bigrams(name: str, character: str, path: Path) -> dict[str, Any]:
    """Count the bigrams of a text."""
    report = coverage(read_lines([path]), name, character).reports[0]
    drafts = sum(need.count for need in report.bigrams if need.layer == "draft")
    lost = sum(tally.count for tally in (*report.unread, *report.unmapped))
    return {
        "lines": report.lines,
        "words": report.words,
        "bigrams": report.occurrences,
        "used": len(report.bigrams),
        "for_90": report.needed["90"],
        "drafted": drafts / max(report.occurrences, 1),
        "gaps": sum(need.layer == "gap" for need in report.bigrams),
        "lost": lost,
    }


def contacts(name: str, character: str, path: Path, most: int) -> dict[str, Any]:
    """Count contacts that are missed in the first lines of a text."""
    said = [line for line in path.read_text("utf-8").splitlines() if line.strip()][:most]
    performer = ll.resolve(name, character)
    spoken = [performer.speaker.speak(text) for text in said]
    found: dict[str, Any] = {}
    for motions, one in (("default", performer), ("paper", performer.with_motion("paper"))):
        counts = {fps: motion.missed(one, fps, spoken) for fps in motion.RATES}
        found[motions] = {fps: lost for fps, (lost, _) in counts.items()}
        found["contacts"] = next(iter(counts.values()))[1]
    return found


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-c", "--character", default="facefx")
    parser.add_argument("--lines", type=int, default=LINES, help="lines performed [%(default)s]")
    parser.add_argument("--only", nargs="*", default=[])
    json_figures.add_option(parser)
    options = parser.parse_args()
    kept: dict[str, Any] = {}
    print(f"{'language':<16}{'bigrams':>8}{'used':>6}{'90 %':>6}{'drafted':>9}{'lost':>6}", end="")
    print(f"{'contacts':>10}{'missed':>8}{'by the paper':>14}")
    for name, path in texts(Library(), options.folder):
        if options.only and name not in options.only:
            continue
        row = bigrams(name, options.character, path)
        try:
            row |= contacts(name, options.character, path, options.lines)
        except LipsyncError as error:
            print(f"{name:<16} {str(error).splitlines()[0]}")
            row |= {"contacts": 0, "default": {0: 0}, "paper": {0: 0}, "failed": True}
        kept[name] = row
        print(
            f"{name:<16}{row['bigrams']:>8}{row['used']:>6}{row['for_90']:>6}{row['drafted']:>9.1%}"
            f"{row['lost']:>6}{row['contacts']:>10}{max(row['default'].values()):>8}"
            f"{max(row['paper'].values()):>14}",
            flush=True,
        )
    json_figures.write_figures(options.json, {"character": options.character, "languages": kept})
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
