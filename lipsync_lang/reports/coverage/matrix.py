"""Reports for every language on every character, from one reading of the lines."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.finding import Paths, folders_of
from lipsync_lang.packs.models import Language
from lipsync_lang.packs.speaker_faces import OTHERS, SpeakerFaces
from lipsync_lang.performing.gesturing import GestureScales
from lipsync_lang.performing.performer import Performer
from lipsync_lang.reports.coverage.corpus import GestureTally, Pages, Reading, count, units
from lipsync_lang.reports.coverage.report import Coverage
from lipsync_lang.reports.coverage.report_figures import CountFigures, report_of
from lipsync_lang.reports.coverage.scripts import letters_of, scripts_of
from lipsync_lang.reports.coverage.total import shared_of, total_of
from lipsync_lang.text.lines import Line


def coverage(  # noqa: PLR0913 two names, and options by keyword
    lines: Iterable[Line],
    language: str | Path | Iterable[str | Path],
    character: str | Path | Iterable[str | Path],
    *,
    paths: Paths = (),
    minutes: float = 5.0,
    weights: Mapping[str, float] | None = None,
    cast: Mapping[str, Sequence[str]] | None = None,
    gestures: GestureScales | None = None,
) -> Coverage:
    """Count the bigrams that lines need, and compare them with the bigrams of characters.

    Raises LipsyncError if there are no lines, a pack is missing or unsound, or a language does not
    read text.

    Parameters
    ----------
    lines : spoken lines, such as those of `read_lines`; iterated over once
    language, character : one or several names or files; each pair gets a report
    paths : folders with priority in pack searches
    minutes : minutes of work for a bigram
    weights : weights of languages in the total, by name; the default is 1
    cast : the characters of each speaker, who speak that speaker's lines alone; all other lines are
        those of `character`. None if every character speaks every line
    gestures : gestures to count, as `Performer.perform` takes them; None for no count
    """
    from lipsync_lang.packs.library import Library
    from lipsync_lang.performing.resolving import resolve

    if not 0 < minutes < float("inf"):
        raise LipsyncError(f"{minutes:g} minutes a bigram: give a number above 0")
    who = _names(character)
    faces = None if cast is None else SpeakerFaces({**cast, OTHERS: tuple(map(str, who))})
    characters = who if faces is None else faces.characters
    folders = folders_of(paths)
    chosen = product(_names(language), characters)
    pairs = [(resolve(one, face, paths=folders, gaps="rest"), str(face)) for one, face in chosen]
    searched = {performer.language: performer.paths for performer, _ in pairs}
    packs = {name: Library(own).language(name).model for name, own in searched.items()}
    tallies = [GestureTally.of(replace(one, unknown="rest"), gestures) for one, _ in pairs]
    readings, reading_of = _shared(pairs, tallies, packs, faces)
    with closing(Pages()) as pages:
        corpus, counts = count(lines, readings, pages, faces)
        if not corpus.lines:
            raise LipsyncError(
                "there are no lines to count; give files, or folders, that hold some text"
            )
        figures = [CountFigures(one, pages) for one in counts]
        reports = tuple(
            report_of(performer, figures[at], minutes, packs[performer.language].title).model_copy(
                update={"gestures": () if tally is None else tally.needs()}
            )
            for (performer, _), at, tally in zip(pairs, reading_of, tallies, strict=True)
            if faces is None or counts[at].lines
        )
    return Coverage(
        corpus=corpus,
        minutes=minutes,
        reports=reports,
        shared=shared_of([performer.report for performer, _ in pairs], reports),
        total=total_of(reports, minutes, weights),
    )


def _shared(
    pairs: Sequence[tuple[Performer, str]],
    tallies: Sequence[GestureTally | None],
    packs: Mapping[str, Language],
    faces: SpeakerFaces | None,
) -> tuple[list[Reading], list[int]]:
    """Return the readings of lines, which pairs of equal counts share, and that of each pair."""
    readings: list[Reading] = []
    keys: list[tuple[object, ...]] = []
    reading_of: list[int] = []
    for (performer, face), tally in zip(pairs, tallies, strict=True):
        speakers = faces and {who for who, names in faces.stated.items() if face in names}
        compiled = performer.compiled
        # All that decides which bigrams the lines have; reading takes nearly all of the time.
        played = compiled.report.trigrams.keys(), units(performer).tobytes()
        key = compiled.manner, compiled.words, played, speakers
        if key not in keys:
            takes = None if faces is None else partial(_speaks, faces, face)
            keys.append(key)
            pack = packs[performer.language]
            readings.append(Reading(performer, scripts_of(pack), takes, letters_of(pack)))
        at = keys.index(key)
        reading_of.append(at)
        if tally is not None:
            readings[at] = readings[at]._replace(tallies=(*readings[at].tallies, tally))
    return readings, reading_of


def _names(given: str | Path | Iterable[str | Path]) -> list[str | Path]:
    return [given] if isinstance(given, (str, Path)) else list(dict.fromkeys(given))


def _speaks(faces: SpeakerFaces, character: str, line: Line) -> bool:
    return character in faces.of(line.speaker)
