"""Plain-text tables for the terminal: transcripts and language packs.

Input is the plain data of the JSON output; output is one string with line breaks.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from lipsync_lang.authoring.new_pack import from_template
from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.presentation.text_table import columns


def transcript_table(told: dict[str, Any]) -> str:
    """Format a transcript as a table of words, phonemes and common phonemes."""
    rows = [("word", told["notation"], "common phonemes")]
    for word in told["words"]:
        labels = " ".join(label["label"] for label in word["labels"])
        common = word.get("pronounced") or [
            name for label in word["labels"] for name in label["common"] or ["?"]
        ]
        unread = [f"(not read: {word['unread']})"] if "unread" in word else []
        rows.append((word["text"], labels, " ".join([*common, *unread])))
    lines = list(columns(rows))
    table = []
    for label, near in told["automatic"].items():
        if near["distance"] or near["loses"]:
            loses = f"loses {', '.join(near['loses'])}" if near["loses"] else ""
            table.append((label, " ".join(near["common"]) or "(mute)", loses))
    if told["automatic"]:
        more = "; these are not exact:" if table else ""
        lines.append(f"{len(told['automatic'])} labels mapped automatically{more}")
        lines += [f"  {line}" for line in columns(table)]
    return "\n".join(lines)


def language_table(told: dict[str, Any]) -> str:
    """Format a language like Table 1 of the paper: phoneme, common phoneme, example, reason.

    `told` is the result of `language_description.describe`. The first notation is listed in full;
    further notations are listed as labels per common phoneme.
    """
    named = [*told["notations"].items()]
    rows = [row for _, first in named[:1] for row in first]
    cells = [(r["label"], r["common"] or "(mute)", r["example"], r["reason"]) for r in rows]
    groups = {name: grouped((row["common"], row["label"]) for row in rows) for name, rows in named}
    differing = [
        (d["label"], d["common"], d["automatic"], d["reason"] or "(no reason given)")
        for d in told["disagreements"]
    ]
    values = {
        **told,
        "listed": columns([("phoneme", "common", "example", "why"), *cells], widest=60),
        # phonemes of two parts come last
        "groups": {
            name: sorted(own.items(), key=lambda group: " " in group[0])
            for name, own in groups.items()
        },
        "measured": columns(_mouth_rows(told["mouths"])),
        "differing": columns([("phoneme", "here", "by features", "why"), *differing], widest=60),
    }
    return from_template("language_table", **values).rstrip("\n")


def _mouth_rows(mouths: Mapping[str, Sequence[Mapping[str, float]]]) -> list[Sequence[str]]:
    """Return the measures of each common phoneme; steps of a moving one have arrows."""
    measures = [*dict.fromkeys(name for steps in mouths.values() for one in steps for name in one)]
    rows: list[Sequence[str]] = [("common", *measures)]
    for phoneme, steps in mouths.items():
        own = ([f"{one[name]:g}" for one in steps if name in one] for name in measures)
        rows.append((phoneme, *(" -> ".join(cell) or "-" for cell in own)))
    return rows
