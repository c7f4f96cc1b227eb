"""Plain-text tables for the terminal: transcripts and language packs.

Input is the plain data of the JSON output; output is one string with line breaks.
"""

from collections.abc import Mapping, Sequence
from typing import Any

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
    also = f", also {', '.join(told['aliases'])}" if told["aliases"] else ""
    lines = [f"{told['title']} ({told['tag']}{also}), {told['path']}"]
    does = {"reads": "reads text with", "speaks": "speaks text with", "moves": "moves with"}
    lines += [f"{words} {told[what]}" for what, words in does.items() if told[what]]
    if told["extends"]:
        lines.append(f"states only what differs from {told['extends']}")
    if told["automatic"]:
        lines.append("automatic: unmapped IPA goes to the nearest common phonemes")
    lines += [f"note: {caveat}" for caveat in told["caveats"]]
    lines += [f"written forms by {one}: {what}" for one, what in told["sources"].items()]
    for number, (name, rows) in enumerate(told["notations"].items()):
        lines.append(f"\n{name}: {len(rows)} labels")
        if number == 0:
            heads = [("phoneme", "common", "example", "why")]
            cells = [(r["label"], r["common"] or "(mute)", r["example"], r["reason"]) for r in rows]
            lines += [f"  {line}" for line in columns(heads + cells, widest=60)]
            continue
        groups = grouped((row["common"], row["label"]) for row in rows)
        for common, labels in sorted(groups.items(), key=lambda group: " " in group[0]):
            lines.append(f"  {common or '(mute)':<10}{'  '.join(labels)}")
    lines += _mouth_table(told["mouths"])
    inventory = told["inventory"]
    if inventory:
        lines.append(f"\ninventory: {len(inventory['segments'])} phonemes, {inventory['source']}")
        absent = inventory["absent"].items()
        lines += [f"  absent: {segment} ({reason})" for segment, reason in absent]
    if told["disagreements"]:
        lines.append("\nlabels that differ from the automatic mapping:")
        table = [("phoneme", "here", "by features", "why")]
        table += [
            (d["label"], d["common"], d["automatic"], d["reason"] or "(no reason given)")
            for d in told["disagreements"]
        ]
        lines += [f"  {line}" for line in columns(table, widest=60)]
    tests = told["tests"]
    failed = f", {tests['failed']} of them fail" if tests["failed"] else ""
    lines.append(f"\n{tests['count']} tests{failed}")
    if tests["refusal"]:
        lines.append(f"  not run: {tests['refusal']}")
    untested = tests["untested"].items()
    lines += [f"  untested {what}: {' '.join(which)}" for what, which in untested if which]
    return "\n".join(lines)


def _mouth_table(mouths: Mapping[str, Sequence[Mapping[str, float]]]) -> list[str]:
    """Return lines with the measures of each common phoneme; steps of a moving one have arrows."""
    measures = [*dict.fromkeys(name for steps in mouths.values() for one in steps for name in one)]
    rows = [("common", *measures)]
    for phoneme, steps in mouths.items():
        own = ([f"{one[name]:g}" for one in steps if name in one] for name in measures)
        rows.append((phoneme, *(" -> ".join(cell) or "-" for cell in own)))
    title = "\nmouths on a model, in widths of the closed mouth:"
    return [title, *(f"  {line}" for line in columns(rows))] if mouths else []
