"""Extras that languages and files need, so that one message names all missing ones."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import LipsyncError, shortlist
from lipsync_lang.base.extras import extras, install_line
from lipsync_lang.sound.speech.speaking.speech_engines import NO_ENGINE

if TYPE_CHECKING:
    from lipsync_lang.text.phonology.manner import Manner

SHOWN_USERS = 3
"""Maximum number of languages or files that a message names for a missing extra."""


def engines_of(
    manner: "Manner", *, spoken: bool = False, heard: bool = False, tts: str | None = None
) -> Iterator[str]:
    """Yield the engines of a language; one of ``tashkeel|espeak`` is enough.

    Parameters
    ----------
    spoken : True if a voice speaks texts
    heard : True if recordings are aligned with their texts
    tts : a speech engine in place of the language's
    """
    if manner.engine is not None:
        yield "|".join(filter(None, (manner.engine, manner.settings.otherwise)))
    if manner.settings.respell:
        yield "|".join(filter(None, (manner.settings.respell, manner.settings.otherwise)))
    if heard:
        yield from (name.partition(":")[0] for name in manner.audio.align[:1])
    voice = tts or (manner.voice[0] if manner.voice else NO_ENGINE)
    if spoken and voice != NO_ENGINE:
        yield voice


def providers(needed: Mapping[str, Iterable[str]]) -> dict[str, list[str]]:
    """Return the extras that provide what is needed, each with its users.

    Parameters
    ----------
    needed : by user, such as a language, its engines, formats and suffixes of files; one of
        ``tashkeel|espeak`` is enough
    """
    found: dict[str, dict[str, None]] = {}
    for user, names in needed.items():
        for choice in names:
            own = [one for one in extras() if not set(choice.split("|")).isdisjoint(one.provides)]
            there = [one for one in own if not one.missing()]
            for one in there or own:
                found.setdefault(one.name, {})[user] = None
    return {name: list(users) for name, users in found.items()}


def missing_for(needed: Mapping[str, Iterable[str]]) -> dict[str, list[str]]:
    """Return the missing ones of the `providers` of what is needed."""
    known = {one.name: one for one in extras()}
    return {name: users for name, users in providers(needed).items() if known[name].missing()}


def missing_words(missing: Mapping[str, Iterable[str]]) -> str:
    """Return the result of `missing_for` in words."""
    parts = (f"{name} (for {shortlist(users, SHOWN_USERS)})" for name, users in missing.items())
    return f"not installed: {', '.join(parts)}"


def refuse_missing(needed: Mapping[str, Iterable[str]]) -> None:
    """Raise one error for all missing extras, with the command that installs them."""
    if missing := missing_for(needed):
        raise LipsyncError(f"{missing_words(missing)}\n  install them: {install_line(*missing)}")
