"""aeneas: a sync map of fragments in JSON.

A fragment has its begin and end in seconds, as text, and the rows of its text. Fragments of several
levels contain smaller ones; the smallest are read.
"""

from operator import methodcaller

from lipsync_lang.schedules import LabelRow, TimedWords, TimingFile, reader, timed_words_of

AENEAS_FORM = (
    '{"fragments": [{"id": "f000001", "begin": "0.000", "end": "2.680", "lines": ["Hello."]}]}'
)


@reader("aeneas", ".json", sniff=methodcaller("holds", "fragments"))
def read_aeneas(source: TimingFile) -> TimedWords:
    """Sync maps of aeneas: the smallest fragments of the text with their times."""
    whole = source.json
    words: list[LabelRow] = []
    waiting = [whole.get("fragments") if isinstance(whole, dict) else None]
    while waiting:
        level = waiting.pop()
        if not isinstance(level, list):
            raise source.fault(f"has no list of fragments; the form is {AENEAS_FORM}")
        for fragment in level:
            lines = fragment.get("lines") if isinstance(fragment, dict) else None
            if not isinstance(lines, list):
                raise source.fault(f"a fragment has no lines; the form is {AENEAS_FORM}")
            if fragment.get("children"):
                waiting.append(fragment["children"])
            else:
                start, end = (
                    source.time(one) if isinstance(one, str) else source.number(one)
                    for one in (fragment.get("begin"), fragment.get("end"))
                )
                words.append(LabelRow(" ".join(map(str, lines)), start, end))
    return timed_words_of(source, words)
