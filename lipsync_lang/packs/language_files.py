"""Languages of the files of a folder: a game has a folder or a file for each translation.

A part of a path may be the name or tag of a language ("german", "pt_BR", "fr.lproj"), alone or with
a word that its neighbours have too ("values" and "values-de", "intro_fr.json" and "intro_it.json").
"""

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

from lipsync_lang.packs.finding import Finder
from lipsync_lang.text.phonology.language_names import folded_language

UNTRANSLATED = {"base", "default", "none", "source"}
"""Names beside those of languages, for texts that nobody has translated."""

_TAG_OR_NAME = re.compile(
    r"[a-z]{2,3}(?:[-_](?:[a-z]{2}|[a-z]{4}|\d{3}))*|[^\W\d_]{4,}", re.IGNORECASE
)
_JOINT = re.compile(r"[-_.]")

NamedLanguage = Callable[[str], str | None]
"""Function that returns the language with a name or tag, or None."""


def spoken_in(
    files: Iterable[Path], root: Path, languages: Mapping[str, Iterable[str]], finder: Finder
) -> dict[Path, set[str]]:
    """Return which of some languages each file below a folder is in, none for another one's files.

    A file without the name of a language is in those that have no file of their own. If the names
    are all of other languages, they say nothing, and each file is in all languages.

    Parameters
    ----------
    languages : names of their packs, with all names and tags that each may have
    """
    answers: dict[str, str] = {}
    for shortened in (False, True):  # "en" is American English, too, if no other language of these
        for own, known in languages.items():
            for answer in map(folded_language, known):
                answers.setdefault(answer.partition("-")[0] if shortened else answer, own)
    named = cache(lambda name: answers.get(folded_language(name)) or finder.language_of(name))
    told = languages_of_files(files, root, named)
    others = languages.keys() - {*told.values()}
    found = {file: languages.keys() & {own} if own else others for file, own in told.items()}
    return found if any(found.values()) else {file: {*languages} for file in found}


def languages_of_files(
    files: Iterable[Path], root: Path, named: NamedLanguage
) -> dict[Path, str | None]:
    """Return the language that each file below a folder is named after, or None.

    The name nearest to the file counts. Words such as "it" and "no" are tags, too, so names count
    only where most of their neighbours are names of languages, too, or the word that these share.

    >>> files = [Path("game/script.rpy"), Path("game/tl/de/script.rpy")]
    >>> list(languages_of_files(files, Path("game"), {"de": "german"}.get).values())
    [None, 'german']
    """
    found: dict[Path, str | None] = dict.fromkeys(files)
    beside: defaultdict[Path, set[Path]] = defaultdict(set)
    for file in found:
        for part in _parts(file, root):
            beside[part.parent].add(part)
    own: dict[Path, str] = {}
    for parts in beside.values():
        own |= _among(parts, named)
    for file in found:
        found[file] = next((own[part] for part in _parts(file, root) if part in own), None)
    return found


def _parts(file: Path, root: Path) -> Iterator[Path]:
    """Yield a file and the folders around it, as far as the root."""
    for part in (file, *file.parents):
        if part == root:
            break
        yield part


def _among(parts: Iterable[Path], named: NamedLanguage) -> dict[Path, str]:
    """Return the languages of the names in a folder; none if most names are of another kind."""
    split = {part: _split(part.stem, named) for part in parts}
    alike = Counter(rest for rest, _ in split.values())
    own = {
        part: language
        for part, (rest, language) in split.items()
        if language and (alike[rest] > 1 or not rest)
    }
    # "values-night" beside "values-de" is not in a language, and says nothing against "de".
    words = {split[part][0] for part in own}
    others = (part.stem.casefold() for part in split.keys() - own.keys())
    against = [one for one in others if one not in UNTRANSLATED and not words & {*_heads(one), one}]
    return own if len(own) > len(against) else {}


def _heads(stem: str) -> Iterator[str]:
    for found in _JOINT.finditer(stem):
        yield stem[: found.start()]


def _split(stem: str, named: NamedLanguage) -> tuple[str, str | None]:
    """Return the word beside the name of a language, and the language; else the stem and None."""
    heads = [*_heads(stem)]
    sides = [("", stem), *((head, stem[len(head) + 1 :]) for head in heads)]
    sides += [(stem[len(head) + 1 :], head) for head in reversed(heads)]
    for rest, name in sides:
        language = named(name) if _TAG_OR_NAME.fullmatch(name) else None
        if language is not None:
            return rest, language
    return stem, None
