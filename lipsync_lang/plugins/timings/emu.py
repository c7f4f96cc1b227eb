"""EMU-SDMS: levels of items in JSON (`_annot.json`).

Segments have times in samples; a segment's duration is one sample short. Items of other levels,
such as words, have the time of the segments that links lead to from them.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from operator import methodcaller

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.tiers import Tier, TimeSpan, read_tiers

EMU_FORM = (
    '{"sampleRate": 16000, "levels": [{"name": "Phonetic", "type": "SEGMENT", "items": [{"id": 1, '
    '"sampleStart": 0, "sampleDur": 799, "labels": [{"name": "Phonetic", "value": "m"}]}]}]}'
)

WORD_LABELS = ("text", "ort", "orthography", "word", "words")
"""Names of labels that spell a word, the surest first: `word` may hold a class of words."""


@reader("emu", ".json", sniff=methodcaller("holds", "levels", "sampleRate"), tiers=True)
def read_emu(source: TimingFile) -> Timings:
    """EMU-SDMS's _annot.json with a level of phonetic segments; words by their links."""
    whole = source.json
    found = source.objects(whole, "levels", EMU_FORM)
    rate = source.rate or source.number(whole.get("sampleRate"))
    if rate <= 0:
        raise source.fault("the field sampleRate must be above 0")
    levels = [(one, source.objects(one, "items", EMU_FORM)) for one in found]
    tiers: list[Tier] = []
    spans: dict[str, TimeSpan] = {}
    for level, items in levels:
        if level.get("type") == "SEGMENT":
            name = str(level.get("name", ""))
            rows = []
            for item in items:
                start = source.number(item.get("sampleStart"))
                # EMU counts the steps from the first sample to the last
                end = start + source.number(item.get("sampleDur")) + 1
                span = spans[str(item.get("id"))] = start / rate, end / rate
                rows.append(LabelRow(_label(source, item, name), *span))
            tiers.append(Tier(name, tuple(rows)))
    words = _words(source, whole, [items for _, items in levels], spans)
    return read_tiers(replace(source, rate=None), [*tiers, *words])


def _label(source: TimingFile, item: Json, name: str) -> str:
    """Return the label that an item has under the name of its level, or its first label."""
    found = source.objects(item, "labels", EMU_FORM)
    labels = {str(one.get("name")): one.get("value") for one in found}
    value = labels.get(name, next(iter(labels.values()), ""))
    return value if isinstance(value, str) else ""


def _words(
    source: TimingFile, whole: Json, levels: list[list[Json]], spans: dict[str, TimeSpan]
) -> Iterator[Tier]:
    """Yield the tier of words that links lead from, if any."""
    known: dict[str, tuple[str, list[Json]]] = {}
    for items in levels:
        for label in source.objects(items[0], "labels", EMU_FORM) if items else ():
            known.setdefault(str(label.get("name")).casefold(), (str(label.get("name")), items))
    spelled = next((known[name] for name in WORD_LABELS if name in known), None)
    if spelled is None:
        return
    below: dict[str, list[str]] = defaultdict(list)
    for link in source.objects(whole, "links", EMU_FORM):
        below[str(link.get("fromID"))].append(str(link.get("toID")))
    name, items = spelled
    ids = [str(item.get("id")) for item in items]
    _reach(source, ids, below, spans)
    rows = [
        LabelRow(_label(source, item, name), *spans[one])
        for one, item in zip(ids, items, strict=True)
        if one in spans
    ]
    if rows:
        yield Tier("words", tuple(rows))


def _reach(
    source: TimingFile, ids: list[str], below: dict[str, list[str]], spans: dict[str, TimeSpan]
) -> None:
    """Add the time of the segments below each item, and below those on the way."""
    # a stack of its own, because links of a damaged file may nest without end
    waiting, entered, left = ids[::-1], set[str](), set[str]()
    while waiting:
        at = waiting[-1]
        if at not in spans and at not in entered:
            entered.add(at)
            loop = next((one for one in below[at] if one in entered and one not in left), None)
            if loop is not None:
                raise source.fault(f"links lead from item {loop} back to itself; remove one")
            waiting += below[at]
            continue
        waiting.pop()
        left.add(at)
        reached = [spans[one] for one in below[at] if one in spans]
        if at not in spans and reached:
            spans[at] = min(start for start, _ in reached), max(end for _, end in reached)
