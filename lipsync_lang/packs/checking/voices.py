"""Checks of the voices that language packs name, against the speech engine that is installed."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.yaml.faults import Fault

if TYPE_CHECKING:
    from lipsync_lang.packs import models
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.source import Loc
    from lipsync_lang.text.phonology.manner import Manner

ESPEAK = "espeak"
"""The engine whose voices are known without a system package."""


def check_voices(languages: "Iterable[Pack[models.Language]]") -> Iterator[Fault]:
    """Yield a fault for each voice that the engine does not have.

    One process answers for all languages. Where the engine is not installed or fails, nothing is
    known of its voices, and the packs' tests say so.
    """
    named = [(pack, loc, voice) for pack in languages for loc, voice in _voices(pack)]
    if not named:
        return
    try:
        missing = _missing(tuple(sorted({voice for _, _, voice in named})))
    except SpeechError:
        return
    for pack, loc, voice in named:
        if voice in missing:
            what = f"eSpeak NG has no voice '{voice}'"
            yield pack.fault(loc, "P226", what, missing[voice])


def lacks_voice(manner: "Manner") -> bool:
    """Return True if a resolved language names a voice that the engine lacks; its pack says where.

    Thus a build reads no pack for it.
    """
    own = manner.engine, manner.settings.voice
    stated = (own, manner.voice or ("", ""), *manner.others.items())
    named = {voice for engine, voice in stated if engine == ESPEAK and voice}
    with suppress(SpeechError):
        return bool(named and _missing(tuple(sorted(named))))
    return False


@cache
def _missing(voices: tuple[str, ...]) -> dict[str, str]:
    """Return hints for the voices that the engine lacks; a process asks once for each set."""
    from lipsync_lang.text.phonology.espeak.process import EspeakProcess

    return EspeakProcess().missing(voices)


def _voices(pack: "Pack[models.Language]") -> "Iterator[tuple[Loc, str]]":
    """Yield the voices of the engine that a language names, with their places."""
    g2p, tts = pack.model.g2p, pack.model.tts
    for field, part in (("g2p", g2p), ("tts", tts)):
        if part is not None and part.engine == ESPEAK and part.voice is not None:
            yield (field, "voice"), part.voice
    if tts is not None and ESPEAK in tts.others:
        yield ("tts", "others", ESPEAK), tts.others[ESPEAK]
