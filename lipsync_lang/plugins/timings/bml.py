"""SmartBody: behaviour markup (BML) with lips, and the replies of its speech relays.

Times are seconds. In BML, ``<lips viseme="Ih" articulation="1.0" start="0.17" end="0.31"/>`` states
both ends of a shape, and ``<sync time="0.17"/>If`` when a word starts. A reply has
``<viseme start="0.17" type="Ih" articulation="1.0"/>``, without an end, within
``<word start= end=>``, which does not say what the word is. Where several shapes start at the same
time, as for characters whose shapes are layered, the one articulated most strongly is read.
"""

from itertools import pairwise
from math import inf

from lipsync_lang.schedules import SILENCE, LabelRow, Schedule, TimingFile, reader
from lipsync_lang.schedules.rows import shapes_of, until_next

SMARTBODY_NOTATION = "smartbody"


def sniff(source: TimingFile) -> bool:
    """Return True for XML with lips or visemes."""
    return source.root is not None and ("<lips " in source.head or "<viseme " in source.head)


@reader("bml", ".bml", ".xml", sniff=sniff)
def read_bml(source: TimingFile) -> Schedule:
    """SmartBody's BML with lips, and the replies of its speech relays with visemes."""
    strongest: dict[float, tuple[float, str, float | None]] = {}  # by start: weight, label and end
    weaker = 0
    for element in source.xml.iter():
        if element.tag not in ("lips", "viseme"):
            continue
        stated_end = element.tag == "lips"  # a reply gives no end
        name = "viseme" if stated_end else "type"
        label, weight = element.get(name), element.get("articulation")
        if label is None:
            raise source.fault(f"a <{element.tag}> has no `{name}`; export it again")
        start = source.time(element.get("start"))
        end = source.time(element.get("end")) if stated_end else None
        shape = (source.time(weight) if weight is not None else 1.0, label, end)
        weaker += start in strongest
        if shape[0] > strongest.get(start, (-inf,))[0]:
            strongest[start] = shape
    if not strongest and source.xml.find(".//curve") is not None:
        raise source.fault("has finished curves, not visemes; no timings can be read")
    told = f"{source.path}: {weaker} weaker shapes start with a stronger one and are left out"
    stated = [
        LabelRow(label, at, end) for at, (_, label, end) in strongest.items() if end is not None
    ]
    marks = [
        (source.time(mark.get("time")), (mark.tail or "").strip())
        for mark in source.xml.iter("sync")
        if mark.get("time") is not None
    ]
    words = [
        LabelRow(text, at, end) for (at, text), (end, _) in pairwise(marks) if text and at < end
    ]
    ends = [source.time(word.get("end")) for word in source.xml.iter("word")]
    open_ended = [(label, at, None) for at, (_, label, end) in strongest.items() if end is None]
    rows, guessed = until_next(source, open_ended, rest=SILENCE, end=max(ends, default=None))
    rows, remarks = stated + rows, [told] * (weaker > 0) + guessed
    return shapes_of(source, rows, words=words, notation=SMARTBODY_NOTATION, remarks=remarks)
