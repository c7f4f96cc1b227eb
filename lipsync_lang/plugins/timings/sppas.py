"""SPPAS: tiers of annotations in XML (`.xra`), in all its versions.

Times are the midpoints of boundaries, in seconds; their radius says how sure they are and is not
used. Where an annotation has several labels or places, the one with the highest score is read.
"""

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.tiers import Tier, read_tiers

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

SPPAS_ROOT = re.compile(r"<Document\s[^>]*\bformat=", re.IGNORECASE)
"""The outermost element; its attributes were written with a capital once."""


def sniff(source: TimingFile) -> bool:
    """Return True for XML with the outermost element of SPPAS and its version."""
    return source.root == "Document" and SPPAS_ROOT.search(source.head) is not None


@reader("sppas", ".xra", sniff=sniff, tiers=True)
def read_sppas(source: TimingFile) -> Timings:
    """SPPAS's .xra with a tier of phones, and the words where there is a tier of tokens."""
    tiers = [
        Tier(tier.get("tiername", "").strip(), tuple(_rows(source, tier)))
        for tier in source.xml.iter("Tier")
        if tier.get("tiername") is not None  # others are references from media
    ]
    return read_tiers(source, tiers)


def _rows(source: TimingFile, tier: "Element") -> Iterator[LabelRow]:
    """Yield the intervals of a tier; points are not sounds."""
    for annotation in tier.iter("Annotation"):
        spans = [one for one in annotation.iter() if one.find("Begin") is not None]
        if not spans:
            continue
        begin, end = (_likeliest(source, spans).find(name) for name in ("Begin", "End"))
        if begin is None or end is None:
            raise source.fault("an interval needs a Begin and an End; save the file again in SPPAS")
        labels = []
        for label in annotation.iter("Label"):
            choices = [one for one in label if one.tag in ("Tag", "Text")]
            if choices:
                labels.append((_likeliest(source, choices).text or "").strip())
        start, stop = (source.time(one.get("midpoint")) for one in (begin, end))
        yield LabelRow(" ".join(filter(None, labels)), start, stop)


def _likeliest(source: TimingFile, choices: "Sequence[Element]") -> "Element":
    """Return the element with the highest score; the first of equals."""
    return max(choices, key=lambda one: source.time(one.get("score", "0")))
