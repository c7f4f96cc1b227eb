"""Tiers as JSON: the Montreal Forced Aligner's form, and the two that praatio saves TextGrids in.

Tiers are a mapping from names, or a list in which each has its name. Entries of intervals are
``[start, end, label]``.
"""

from operator import methodcaller
from typing import Any

from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.tiers import Tier, read_tiers

TIERS_FORM = '{"tiers": {"phones": {"type": "interval", "entries": [[START, END, "LABEL"], ...]}}}'


@reader("mfa-json", ".json", sniff=methodcaller("holds", "tiers"), tiers=True)
def read_mfa_json(source: TimingFile) -> Timings:
    """Tiers as JSON, as the Montreal Forced Aligner and praatio write them."""
    document = source.json
    tiers = document.get("tiers") if isinstance(document, dict) else None
    named: list[tuple[Any, Any]]
    if isinstance(tiers, dict):
        named = list(tiers.items())
    else:
        listed = source.object_list(tiers, f"has no tiers; the form is {TIERS_FORM}")
        named = [(tier.get("name"), tier) for tier in listed]
    found = []
    for name, tier in named:
        if not isinstance(tier, dict) or not isinstance(tier.get("entries"), list):
            raise source.fault(f"tier {name!r} has no entries; the form is {TIERS_FORM}")
        # The second name is that of praatio's form "textgrid".
        kind = tier.get("type", tier.get("class"))
        if isinstance(kind, str) and kind.casefold().startswith("interval"):
            rows = []
            for entry in tier["entries"]:
                match entry:
                    case [start, end, str(label)]:
                        rows.append(LabelRow(label, source.number(start), source.number(end)))
                    case _:
                        what = f"an entry is [start, end, label], not {str(entry)[:80]}"
                        raise source.fault(f"tier {name!r}: {what}")
            found.append(Tier(str(name).strip(), tuple(rows)))
    return read_tiers(source, found)
