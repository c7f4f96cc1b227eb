"""Commands that write drafts of the next bigrams into banks."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lipsync_lang.coverage.total import WorkItem


def draft_calls(items: "Sequence[WorkItem]") -> Iterator[str]:
    """Yield few commands that draft all items; items in a bank of their own need none.

    A command drafts for one language and one pose set. Each command has the language that serves
    most of the remaining items, or the first of several.
    """
    left: dict[str, list[WorkItem]] = {}
    for item in items:
        if not item.bank:
            left.setdefault(item.poseset, []).append(item)
    for poseset, asked in left.items():
        missing = asked
        while missing:
            counts = Counter(name for item in missing for name in item.languages)
            best = max(counts, key=counts.__getitem__)
            now = [item.bigram for item in missing if best in item.languages]
            yield f"lipsync-lang bank draft -l {best} -c {poseset} --write {' '.join(now)}"
            missing = [item for item in missing if best not in item.languages]
