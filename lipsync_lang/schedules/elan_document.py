"""ELAN's documents (EAF 3.0), written from tiers of labels with times in seconds.

Each annotation has two time slots of its own, so that ELAN moves one boundary at a time. Times are
whole milliseconds.
"""

from collections.abc import Iterable, Mapping
from itertools import chain
from xml.etree import ElementTree as ET

MILLISECONDS = 1000

DATE = "1970-01-01T00:00:00+00:00"
"""A date is required; a constant one makes equal files of equal timings."""

TIMED, REFERRING = "default-lt", "reference"
"""Types of tiers: with times of their own, and of notes on the annotations of another tier."""

Spans = Iterable[tuple[str, float, float]]
"""Label, start and end in seconds, in order."""


def elan_document(tiers: Mapping[str, Spans], refers: Mapping[str, Spans]) -> str:
    """Return an ELAN document.

    Parameters
    ----------
    tiers : labels of each tier, by its name
    refers : notes on the labels of the first tier that start at the same time, by tier name
    """
    root = ET.Element("ANNOTATION_DOCUMENT", AUTHOR="", DATE=DATE, FORMAT="3.0", VERSION="3.0")
    ET.SubElement(root, "HEADER", MEDIA_FILE="", TIME_UNITS="milliseconds")
    order = ET.SubElement(root, "TIME_ORDER")
    named: dict[float, str] = {}
    for name, spans in tiers.items():
        tier = ET.SubElement(root, "TIER", LINGUISTIC_TYPE_REF=TIMED, TIER_ID=name)
        starts = _timed(order, tier, list(spans))
        named = named or starts
    parent = next(iter(tiers), "")
    for name, spans in refers.items():
        notes = [(named[start], label) for label, start, _ in spans if start in named]
        if notes:
            tier = ET.SubElement(
                root, "TIER", LINGUISTIC_TYPE_REF=REFERRING, PARENT_REF=parent, TIER_ID=name
            )
            _notes(tier, notes)
    _types(root)
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _timed(
    order: ET.Element, tier: ET.Element, spans: list[tuple[str, float, float]]
) -> dict[float, str]:
    """Add annotations with times; return the ID of each by its start in seconds."""
    starts: dict[float, str] = {}
    times = dict.fromkeys(sorted({*chain.from_iterable(span[1:] for span in spans)}), 0)
    last = -1
    for one in times:
        times[one] = last = max(round(one * MILLISECONDS), last + 1)  # no two boundaries are one
    for number, (label, start, end) in enumerate(spans):
        name = f"{tier.get('TIER_ID')}{number}"
        slots = []
        for place, at in (("a", start), ("b", end)):
            slots.append(f"{name}{place}")
            ET.SubElement(order, "TIME_SLOT", TIME_SLOT_ID=slots[-1], TIME_VALUE=str(times[at]))
        both = {"TIME_SLOT_REF1": slots[0], "TIME_SLOT_REF2": slots[1]}
        _annotate(tier, "ALIGNABLE_ANNOTATION", name, both, label)
        starts[start] = name
    return starts


def _notes(tier: ET.Element, notes: list[tuple[str, str]]) -> None:
    for number, (of, label) in enumerate(notes):
        name = f"{tier.get('TIER_ID')}{number}"
        _annotate(tier, "REF_ANNOTATION", name, {"ANNOTATION_REF": of}, label)


def _annotate(
    tier: ET.Element, kind: str, name: str, refers: Mapping[str, str], label: str
) -> None:
    annotation = ET.SubElement(tier, "ANNOTATION")
    element = ET.SubElement(annotation, kind, {"ANNOTATION_ID": name, **refers})
    ET.SubElement(element, "ANNOTATION_VALUE").text = label


def _types(root: ET.Element) -> None:
    """Add the types of tiers, and what the second one is bound by."""
    shared = {"GRAPHIC_REFERENCES": "false"}
    ET.SubElement(root, "LINGUISTIC_TYPE", shared, LINGUISTIC_TYPE_ID=TIMED, TIME_ALIGNABLE="true")
    ET.SubElement(
        root, "LINGUISTIC_TYPE", shared, LINGUISTIC_TYPE_ID=REFERRING, TIME_ALIGNABLE="false",
        CONSTRAINTS="Symbolic_Association",
    )  # fmt: skip
    ET.SubElement(
        root, "CONSTRAINT", STEREOTYPE="Symbolic_Association",
        DESCRIPTION="1-1 association with a parent annotation",
    )  # fmt: skip
