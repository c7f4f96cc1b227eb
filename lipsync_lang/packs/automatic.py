"""Languages without a pack: what an engine reads, mapped by the features of the IPA.

They are called ENGINE:CODE, as in `espeak:sw`. Whether the engine knows the code, it says itself
when it reads text. `ipa:CODE` reads none: for timed phonemes in IPA, whoever wrote them.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.yaml.source import YamlSource

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Library, Pack
    from lipsync_lang.packs.models import Language


class IpaEngine(NamedTuple):
    """What gives IPA: the field of `g2p` with its code, if it reads text, and whether it speaks."""

    field: str | None = None
    speaks: bool = False


READERS: dict[str, IpaEngine] = {
    "espeak": IpaEngine("voice", speaks=True),
    "epitran": IpaEngine("code"),
    IPA: IpaEngine(),
}
"""What gives IPA, by name; add an engine to make its languages known."""

CODE = re.compile(r"(?P<tag>[A-Za-z0-9]+([-_][A-Za-z0-9]+)*)(\+[A-Za-z0-9_-]+)?")
"""An engine's code of a language; eSpeak adds a manner of speaking after `+`."""

HOW = f"a language without a pack is {' or '.join(f'{name}:CODE' for name in READERS)}"
"""How to name such a language, for hints."""


def automatic(library: "Library", name: str) -> "Pack[Language] | None":
    """Make a language of an engine's code; None where the name is not of that form."""
    from lipsync_lang.packs.library import Pack
    from lipsync_lang.packs.models import Language

    engine, _, code = name.partition(":")
    coded = CODE.fullmatch(code)
    if engine not in READERS or coded is None:
        return None
    reader = READERS[engine]
    common = library.common().model
    beyond = (p for p in common.phonemes if p not in {*common.base, common.silence})
    data: dict[str, Any] = {
        "kind": "language",
        "format": 1,
        "name": engine,
        "title": f"{code} as {engine} has it, mapped automatically",
        "tag": coded["tag"].replace("_", "-"),
        "adds": dict.fromkeys(beyond),
        "g2p": {"engine": engine, reader.field: code, "notation": IPA} if reader.field else None,
        "tts": {"engine": engine, "voice": code} if reader.speaks else None,
        "notations": {IPA: {}},
        "automatic": True,
        "caveats": ("nobody who speaks it has checked it",),
    }
    model = Language.model_validate(data).model_copy(update={"name": name})
    return Pack(model, (YamlSource(Path(name), {**data, "name": name}),))
