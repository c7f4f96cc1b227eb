"""ELAN: tiers of annotations in XML (`.eaf`).

An annotation lies between two time slots, in milliseconds. Slots without a value part the time
between their neighbours evenly, as ELAN shows them. An annotation that refers to another has its
time; several that refer to one share it evenly, in their order.
"""

from collections import Counter
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from operator import methodcaller
from typing import TYPE_CHECKING, Any

from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND
from lipsync_lang.schedules.tiers import Tier, TimeSpan, read_tiers

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

ELAN_ROOT = "ANNOTATION_DOCUMENT"
ANNOTATIONS = ".//ANNOTATION/*"

Reference = tuple[str, int, int]
"""An annotation's parent, its place among those of the tier that share it, and their number."""


@reader("elan", ".eaf", sniff=methodcaller("has_root", ELAN_ROOT), tiers=True)
def read_elan(source: TimingFile) -> Timings:
    """ELAN's .eaf with a tier of phones; the words of its speaker are taken along."""
    document = source.xml
    if document.tag != ELAN_ROOT:
        raise source.fault("is not an ELAN document; save it again in ELAN")
    elements = list(document.iter("TIER"))
    parents = {one.get("TIER_ID", ""): [one.get("PARENT_REF")] for one in elements}
    told = "tier '{}' is its own parent; give it another parent in ELAN (Change Parent)"
    _parents_first(source, parents, "TIER_ID", told)
    spans = _spans(source, document, elements)
    rate = source.rate or MILLISECONDS_PER_SECOND
    tiers = []
    timeless = 0
    for element in elements:
        rows = []
        for one in element.iterfind(ANNOTATIONS):
            text, span = (one.findtext("ANNOTATION_VALUE") or "").strip(), spans.get(_id(one))
            if span:
                rows.append(LabelRow(text, span[0] / rate, span[1] / rate))
            timeless += bool(text) and span is None
        tiers.append(Tier(element.get("TIER_ID", "").strip(), tuple(rows)))
    told = f"{source.path}: annotations without a time are left out: {timeless}"
    # The times are in seconds by now.
    return read_tiers(replace(source, rate=None), tiers, remarks=[told] if timeless else ())


def _id(annotation: "Element") -> str:
    return annotation.get("ANNOTATION_ID", "")


def _parents_first(
    source: TimingFile, parents: dict[str, list[Any]], field: str, fault: str
) -> list[Any]:
    """Return names after their parents; raise an error if one is its own, through others even."""
    try:
        return list(TopologicalSorter(parents).static_order())
    except CycleError as error:
        at = next(name for name in parents if name in error.args[1])
        line = source.line_of(f'{field}="{at}"')
        raise source.fault(fault.format(at), line) from None


def _spans(source: TimingFile, document: "Element", tiers: "list[Element]") -> dict[str, TimeSpan]:
    """Return the start and end of each annotation that has any, by its ID."""
    slots = {
        slot.get("TIME_SLOT_ID", ""): source.time(slot.get("TIME_VALUE"))
        for slot in document.iter("TIME_SLOT")
        if slot.get("TIME_VALUE") is not None
    }
    spans: dict[str, TimeSpan] = {}
    references: dict[str, Reference] = {}
    for tier in tiers:
        found = tier.findall(ANNOTATIONS)
        spans |= _aligned(found, slots)
        parents = [(_id(one), ref) for one in found if (ref := one.get("ANNOTATION_REF"))]
        counts = Counter(parent for _, parent in parents)
        places: Counter[str] = Counter()
        for name, parent in parents:
            references[name] = (parent, places[parent], counts[parent])
            places[parent] += 1
    waiting = {name: [parent] for name, (parent, _, _) in references.items() if name not in spans}
    told = "annotation '{}' refers to itself; delete it in ELAN, and create it again"
    for name in _parents_first(source, waiting, "ANNOTATION_ID", told):
        parent, place, among = references.get(name, ("", 0, 0))
        if name in waiting and parent in spans:
            start, end = spans[parent]
            step = (end - start) / among
            spans[name] = (start + place * step, start + (place + 1) * step)
    return spans


def _aligned(annotations: "list[Element]", slots: dict[str, float]) -> dict[str, TimeSpan]:
    """Return the spans of a tier's annotations between slots; chains without times share theirs."""
    spans: dict[str, TimeSpan] = {}
    chain: list[str] = []
    start: float | None = None
    due: str | None = None
    for one in annotations:
        first, last = one.get("TIME_SLOT_REF1"), one.get("TIME_SLOT_REF2")
        if first is None or last is None:
            continue
        if first in slots or first != due:
            chain, start = [], slots.get(first)
        chain.append(_id(one))
        due = last
        if last in slots:
            if start is not None:
                step = (slots[last] - start) / len(chain)
                ends = [start + step * (n + 1) for n in range(len(chain) - 1)] + [slots[last]]
                spans |= dict(zip(chain, zip([start, *ends], ends, strict=False), strict=True))
            chain, start, due = [], slots[last], None
    return spans
