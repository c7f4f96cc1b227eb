"""Choice among a language's aligners, which are tried in order until one is sure."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from lipsync_lang.errors import SpeechError
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule
from lipsync_lang.speech.align.aligners import ALIGNERS, BatchAligner
from lipsync_lang.speech.engine_names import engine_and_model
from lipsync_lang.speech.in_turn import raised, tried
from lipsync_lang.speech.speaking import Speaker
from lipsync_lang.speech.written_text import WrittenText, as_written

if TYPE_CHECKING:
    from lipsync_lang.speech.align.aligners import Aligner

SHOWN_WORDS = 5
"""Maximum number of doubtful words in a remark."""


class NamedAligner(NamedTuple):
    """An aligner with its name, and its model of the language."""

    name: str
    aligner: "Aligner"
    model: str | None

    def all(
        self, pairs: "Iterable[tuple[Callable[[], Audio], str]]", speaker: Speaker
    ) -> "Iterable[Schedule | SpeechError]":
        """Yield for each sound and text the schedule, or the error of aligning it."""
        if isinstance(self.aligner, BatchAligner):
            return self.aligner.align_many(pairs, speaker, self.model)

        def align_one(pair: tuple[Callable[[], Audio], str]) -> Schedule:
            return self.aligner.align(pair[0](), pair[1], speaker, self.model)

        return map(tried(align_one), pairs)


def aligners(speaker: Speaker, named: str | None) -> list[NamedAligner]:
    """Return the language's aligners in order, or the one that is named."""
    stated = speaker.manner.audio
    models = dict.fromkeys(stated.align) | {stated.align[0]: stated.model}
    if named is not None:
        models = {one: model for one, model in models.items() if named in (one, _name(one))} or {
            named: None
        }
    pairs = [engine_and_model(named, one, model) for one, model in models.items()]
    return [NamedAligner(n or "", ALIGNERS.find(n or "", SpeechError), m) for n, m in pairs]


def _name(engine: str) -> str:
    return engine.partition(":")[0].strip()


def surest(
    speaker: Speaker,
    sound: Callable[[], Audio],
    text: WrittenText,
    first: Schedule | SpeechError,
    engines: "Sequence[NamedAligner]",
) -> Schedule:
    """Return the most confident result of a language's aligners, tried until one is sure."""
    best, results = first, [(engines[0].name, _sureness(first))]
    for engine in engines[1:]:
        if _sureness(best) >= DOUBTFUL or _words_fit(best):
            break
        (other,) = engine.all([(sound, text.text)], speaker)
        results.append((engine.name, _sureness(other)))
        if _sureness(other) > _sureness(best):
            best = other
    schedule = _doubted(raised(best))
    if len(results) > 1:
        asked = ", ".join(
            f"{name} {'failed' if sure < 0 else f'{sure:.2f}'}" for name, sure in results
        )
        kept = max(results, key=lambda one: one[1])[0]
        remark = f"aligned by {kept}, the most confident of: {asked}"
        if isinstance(first, SpeechError):
            remark += f" ({first})"
        schedule = replace(schedule, remarks=(*schedule.remarks, remark))
    return as_written(text, schedule)


def _words_fit(result: Schedule | SpeechError) -> bool:
    """Return True if most words fit, so that only other sound makes the line doubtful."""
    words = result.words if isinstance(result, Schedule) else ()
    sure = sorted(word.confidence for word in words if word.confidence is not None)
    return bool(sure) and sure[len(sure) // 2] >= DOUBTFUL


def _doubted(schedule: Schedule) -> Schedule:
    """Return a schedule with a remark if it is in doubt, and the words that are least sure."""
    sure = schedule.confidence
    if sure is None or sure >= DOUBTFUL:
        return schedule
    words = [
        (word.confidence, f"'{word.text}' at {schedule.times[word.first]:.1f} s")
        for word in schedule.words
        if word.confidence is not None and word.confidence < DOUBTFUL
    ]
    least = [place for _, place in sorted(words)[:SHOWN_WORDS]]
    told = (
        f"the text hardly fits the recording (confidence {sure:.2f}); check that it is the right "
        f"text, in {schedule.language}" + (f"; in doubt: {', '.join(least)}" if least else "")
    )
    return replace(schedule, remarks=(told, *schedule.remarks))


def _sureness(result: Schedule | SpeechError) -> float:
    """Return the confidence of a result: -1 for an error, 1 if the aligner states none."""
    if isinstance(result, SpeechError):
        return -1.0
    return 1.0 if result.confidence is None else result.confidence
