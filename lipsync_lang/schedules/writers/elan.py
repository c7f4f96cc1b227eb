"""ELAN documents (EAF 3.0).

Each annotation has two time slots of its own, so that ELAN moves one boundary at a time. Times are
whole milliseconds.
"""

from collections.abc import Mapping
from itertools import chain
from xml.etree import ElementTree as ET

from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.schedules.tiers import CONFIDENCE_TIER, LabelSpan, tiers_of

EAF_DATE = "1970-01-01T00:00:00+00:00"
"""A date is required; a constant one makes equal files of equal timings."""

TIMED, REFERRING = "default-lt", "reference"
"""Types of tiers: with times of their own, and of notes on the annotations of another tier."""


def elan_text(schedule: Schedule) -> str:
    """Return a schedule as an ELAN document with tiers of words and phones, in milliseconds.

    Silence is left out, but for that at the end. Confidences, if any, are a tier that refers to the
    words.
    """
    tiers = tiers_of(schedule)
    phones = tiers["phones"]
    # the silence at the end keeps the length, which a document states nowhere else
    sounds = [one for one in phones[:-1] if one[0] != SILENCE] + phones[-1:]
    root = ET.Element("ANNOTATION_DOCUMENT", AUTHOR="", DATE=EAF_DATE, FORMAT="3.0", VERSION="3.0")
    ET.SubElement(root, "HEADER", MEDIA_FILE="", TIME_UNITS="milliseconds")
    order = ET.SubElement(root, "TIME_ORDER")
    words = _add_timed_tier(root, order, "words", tiers["words"])
    _add_timed_tier(root, order, "phones", sounds)
    if CONFIDENCE_TIER in tiers:
        tier = ET.SubElement(
            root, "TIER", LINGUISTIC_TYPE_REF=REFERRING, PARENT_REF="words", TIER_ID=CONFIDENCE_TIER
        )
        for number, (label, start, _) in enumerate(tiers[CONFIDENCE_TIER]):
            refers = {"ANNOTATION_REF": words[start]}
            _annotate(tier, "REF_ANNOTATION", f"{CONFIDENCE_TIER}{number}", refers, label)
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
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _add_timed_tier(
    root: ET.Element, order: ET.Element, name: str, spans: list[LabelSpan]
) -> dict[float, str]:
    """Add a tier of annotations with times; return the ID of each by its start in seconds."""
    tier = ET.SubElement(root, "TIER", LINGUISTIC_TYPE_REF=TIMED, TIER_ID=name)
    starts: dict[float, str] = {}
    times = dict.fromkeys(sorted({*chain.from_iterable(span[1:] for span in spans)}), 0)
    last = -1
    for time in times:  # no two boundaries are one
        times[time] = last = max(round(time * MILLISECONDS_PER_SECOND), last + 1)
    for number, (label, start, end) in enumerate(spans):
        annotation = f"{name}{number}"
        slots = {"TIME_SLOT_REF1": f"{annotation}a", "TIME_SLOT_REF2": f"{annotation}b"}
        for slot, at in zip(slots.values(), (start, end), strict=True):
            ET.SubElement(order, "TIME_SLOT", TIME_SLOT_ID=slot, TIME_VALUE=str(times[at]))
        _annotate(tier, "ALIGNABLE_ANNOTATION", annotation, slots, label)
        starts[start] = annotation
    return starts


def _annotate(
    tier: ET.Element, kind: str, name: str, refers: Mapping[str, str], label: str
) -> None:
    annotation = ET.SubElement(tier, "ANNOTATION")
    element = ET.SubElement(annotation, kind, {"ANNOTATION_ID": name, **refers})
    ET.SubElement(element, "ANNOTATION_VALUE").text = label
