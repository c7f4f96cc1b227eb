"""Merge a language with the language it extends, which may extend another."""

from pathlib import Path
from typing import TYPE_CHECKING, cast
from unicodedata import normalize

from lipsync_lang.base.errors import PackError
from lipsync_lang.packs.automatic import automatic
from lipsync_lang.packs.library import Library, Pack
from lipsync_lang.packs.yaml.faults import Fault, shown

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Language

REPLACED_FIELDS = ("g2p", "tts", "audio", "automatic", "gesture_words")
"""Fields that a child replaces as a whole, or inherits."""

MERGED_FIELDS = ("adds", "durations", "words", "examples", "reasons")
"""Mappings that are merged; a child's entry replaces its parent's."""


def extended(library: Library, path: Path) -> "Pack[Language]":
    """Load a language with all that it inherits; raise `PackFaults` for an unsound parent."""
    line: list[Pack[Language]] = []
    while True:
        pack = cast("Pack[Language]", library.load(path, "language", path.stem))
        line.append(pack)
        parent = pack.model.extends
        if parent is None:
            break
        try:
            path = library.find("language", parent)
        except PackError:
            made = automatic(library, parent)
            if made is not None:
                line.append(made)
                break
            known = {found.name for found in library.names("language")}
            fault = pack.unknown(("extends",), "P210", "language", parent, known)
            raise library.failing(fault) from None
        if path.stem == pack.path.stem:
            # A language that extends its own name extends the pack that it shadows.
            beneath = library.beneath(pack.path)
            if beneath is None:
                what = f"there is no other language '{parent}' to extend"
                hint = "name another language, or leave `extends` out"
                raise library.failing(pack.fault(("extends",), "P210", what, hint))
            path = beneath
        if path in {member.path for member in line}:
            names = " -> ".join([*(member.model.name for member in line), path.stem])
            what = f"languages extend each other in a circle: {names}"
            hint = "one of them must not extend another"
            raise library.failing(pack.fault(("extends",), "P211", what, hint))
    model = line[-1].model
    for child in reversed(line[:-1]):
        model = merge(model, child.model)
    return Pack(model, tuple(pack.source for pack in line))


def merge(parent: "Language", child: "Language") -> "Language":
    """Merge a child into its parent; a child that takes its parent's name keeps its tests."""
    stated = child.model_fields_set
    taken = {name: getattr(parent, name) for name in REPLACED_FIELDS if name not in stated}
    taken |= {name: {**getattr(parent, name), **getattr(child, name)} for name in MERGED_FIELDS}
    if child.name == parent.name:
        stated_anew = {test.text for test in child.tests}
        kept = (test for test in parent.tests if test.text not in stated_anew)
        taken["tests"] = (*child.tests, *kept)
    taken["text"] = child.text or parent.text
    if parent.text is not None and child.text is not None:
        forms = {name: getattr(child.text, name) for name in child.text.model_fields_set}
        for name, value in forms.items():  # mappings by their entries, the rest as a whole
            forms[name] = (
                {**getattr(parent.text, name), **value} if isinstance(value, dict) else value
            )
        taken["text"] = parent.text.model_copy(update=forms)
    taken["silence"] = tuple(dict.fromkeys((*parent.silence, *child.silence)))
    notations = {name: dict(labels) for name, labels in parent.notations.items()}
    for name, labels in child.notations.items():
        notations.setdefault(name, {}).update(labels)
    return child.model_copy(update={**taken, "notations": notations})


def test_fault(pack: "Pack[Language]", index: int, what: str, hint: str, *more: str) -> Fault:
    """Return the fault of a test at its place, which is another file if the test is inherited."""
    text = pack.model.tests[index].text
    for source in pack.sources[1:] if index >= len(pack.source.data.get("tests") or ()) else ():
        for number, test in enumerate(source.data.get("tests") or ()):
            if normalize("NFC", test["text"]) == normalize("NFC", text):
                place = source.where(("tests", number))
                hint = f"correct the map, or state this test again in {shown(pack.path)}"
                return Fault(shown(source.path), *place, "P221", what, hint)
    return pack.fault(("tests", index, *more), "P221", what, hint)
