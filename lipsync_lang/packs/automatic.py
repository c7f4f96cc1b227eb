"""Languages without a pack: an engine turns text into IPA, and IPA is mapped by its features.

Their names have the form ENGINE:CODE, as in `espeak:sw`. An unknown code is reported by the engine
when it first reads text. The text of `ipa:CODE` is IPA itself.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.source import YamlSource
from lipsync_lang.text.phonology.language_names import folded_language

if TYPE_CHECKING:
    from collections.abc import Callable

    from lipsync_lang.packs.models import Language, Phonemes

IPA_ENGINES = {"espeak": "voice", "epitran": "code", IPA: "code"}
"""Sources of IPA, each with the field of `g2p` that holds its code; a voice speaks, too."""

UNDETERMINED = f"{IPA}:und"
"""Any language; `und` is the tag of an undetermined one."""

LANGUAGE_CODE = re.compile(r"(?P<tag>[A-Za-z0-9]+([-_][A-Za-z0-9]+)*)(\+[A-Za-z0-9_-]+)?")
"""An engine's code of a language; eSpeak adds a voice variant after `+`."""

HOW = f"a language without a pack is {' or '.join(f'{name}:CODE' for name in IPA_ENGINES)}"
"""The form of such a language's name, for hints."""


def unpacked(name: str) -> str | None:
    """Return ENGINE:CODE of the voice of eSpeak NG with this code, title or word of its title."""
    from lipsync_lang.text.phonology.espeak.process import EspeakProcess

    try:
        voices = EspeakProcess().voices()
    except SpeechError:
        return None
    wanted = folded_language(name)
    titles = {code: folded_language(title) for code, title in voices.items()}
    # a whole title goes before a word of one, since 'latin' is also the script of other languages
    found = [code for code, title in titles.items() if wanted in (code.lower(), title)]
    found += [code for code, title in titles.items() if wanted in re.findall(r"\w+", title)]
    return f"espeak:{found[0]}" if found else None


def coded_language(name: str) -> "re.Match[str] | None":
    """Return the code of a name ENGINE:CODE, with its `tag`; None for any other name."""
    engine, _, code = name.partition(":")
    return LANGUAGE_CODE.fullmatch(code) if engine in IPA_ENGINES else None


def automatic(name: str, phonemes: "Callable[[], Pack[Phonemes]]") -> "Pack[Language] | None":
    """Make the language for a name ENGINE:CODE; None for any other name.

    `phonemes` loads the common ones, and is called for such a name alone.
    """
    from lipsync_lang.packs.models import Language

    engine, _, code = name.partition(":")
    coded = coded_language(name)
    if coded is None:
        return None
    field = IPA_ENGINES[engine]
    common = phonemes().model
    # features lead to any common phoneme, and no pack says which the language has
    beyond = (p for p in common.phonemes if p not in {*common.base, common.silence})
    data: dict[str, Any] = {
        "kind": "language",
        "format": 1,
        "name": engine,
        "title": f"{code} as {engine} has it, mapped automatically",
        "tag": coded["tag"].replace("_", "-"),
        "adds": dict.fromkeys(beyond),
        "g2p": {"engine": engine, field: code, "notation": IPA},
        "tts": {"engine": engine, field: code} if field == "voice" else None,
        "notations": {IPA: {}},
        "automatic": True,
        "caveats": ("no speaker of the language has checked it",),
    }
    # a name with a colon is none that a file may have, so the model is made under another
    model = Language.model_validate(data).model_copy(update={"name": name})
    return Pack(model, (YamlSource(Path(name), {**data, "name": name}),))
