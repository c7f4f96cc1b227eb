"""Typing errors in a shipped pack: located faults or a valid pack, never a crash.

Edits are seeded by their number, so that one that fails can be run again.
"""

from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
from fuzz.mutators import SLIPS, spoil
from lanes import full, swept
from shipped import LIBRARY

from lipsync_lang import LipsyncError, Schedule, resolve
from lipsync_lang.packs.checking import pack_checks as checks
from lipsync_lang.packs.checking.ipa_checks import check_ipa
from lipsync_lang.packs.checking.rig_checks import check_rig
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.models.validation import validated
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.building import scan
from lipsync_lang.packs.yaml.faults import Fault

EDITS = 2_400
RESOLVED = 300
BATCH = 100
FEW = 25
ROOT = built_in()
FILES = sorted([*ROOT.glob("languages/*.yaml"), *ROOT.glob("posesets/*/**/*.yaml")])
assert FILES, "a sweep over nothing passes"


def edited(number: int) -> tuple[Path, bytes]:
    """Return a shipped file, and its content after one to three typing errors."""
    rng = Random(number)  # noqa: S311 repeatable, not secret
    path = rng.choices(FILES, [1 / (8_000 + file.stat().st_size) for file in FILES])[0]
    text = path.read_bytes().decode()
    for _ in range(rng.choice((1, 1, 2, 3))):
        text = rng.choice(SLIPS)(rng, text) or "xx"
    return path, spoil(rng, text.encode()) if rng.random() < 0.05 else text.encode()


def compared(pack: Pack) -> list[Fault]:
    """Run the checks of a kind of pack."""
    library, model = LIBRARY, pack.model
    common = library.common().model
    phonemes = set(common.phonemes)
    if model.kind == "phonemes":
        return [*checks.check_phonemes(pack)]
    if model.kind == "ipa":
        return [*check_ipa(pack, common)]
    if model.kind == "language":
        return [*checks.check_language(pack, common)]
    if model.kind == "poseset":
        return [*checks.check_poseset(pack, phonemes)]
    poseset = library.poseset(pack.path.parent.parent.name).model
    if model.kind == "bank":
        return [*checks.check_bank(pack, poseset, phonemes, ())]
    known = {found.name for found in library.names("poseset")}
    to = library.poseset(model.to).model if model.to in known else None
    return [*check_rig(pack, poseset, known, to)]


@full
@pytest.mark.parametrize("first", swept(range(0, EDITS, BATCH), quick=2))
def test_a_slip_gives_located_faults_or_a_sound_pack(first):
    for number in range(first, first + BATCH):
        path, content = edited(number)
        source = scan(path, content)
        pack, faults = validated(source)
        found = list(faults) if pack is None else compared(Pack(pack, (source,)))
        assert pack is not None or faults, f"edit {number}"
        rows = (
            content.decode("utf-8", "replace").replace("\r\n", "\n").replace("\r", "\n").split("\n")
        )
        for fault in found:
            assert 1 <= fault.line <= len(rows), f"edit {number}: {fault}"
            assert 1 <= fault.column <= len(rows[fault.line - 1]) + 1, f"edit {number}: {fault}"
            assert str(fault).replace("\n  hint", "  hint").isprintable()


@full
def test_the_edits_do_break_packs():
    """The sweep is useful: most edits cause faults, with many codes, and some do not."""
    codes: dict[str, int] = {}
    sound = 0
    for number in range(0, EDITS, 8):
        path, content = edited(number)
        pack, faults = validated(scan(path, content))
        sound += pack is not None
        for fault in faults:
            codes[fault.code] = codes.get(fault.code, 0) + 1
    assert len(codes) >= 10
    assert 0 < sound < EDITS / 8 / 2


SCHEDULE = Schedule.from_intervals(
    [("HH", 0.0, 0.08), ("AH", 0.08, 0.15), ("P", 0.15, 0.2), ("IY", 0.2, 0.4), ("_", 0.4, 0.9)],
    notation="arpabet",
)


@full
@pytest.mark.parametrize("first", swept(range(0, RESOLVED, FEW)))
def test_what_is_sound_resolves_and_performs_within_its_promises(first, tmp_path):
    for number in range(first, first + FEW):
        path, content = edited(number)
        source = scan(path, content)
        if validated(source)[0] is None:
            continue
        shadow = tmp_path / str(number) / path.relative_to(ROOT)
        shadow.parent.mkdir(parents=True)
        shadow.write_bytes(content)
        try:
            performer = resolve(
                "english", "facefx", paths=[tmp_path / str(number)], cache=False, gaps="rest"
            )
            weights = replace(performer, unknown="rest").perform(SCHEDULE, fps=30).weights
        except LipsyncError:  # told in words; anything else is a failure
            continue
        assert weights.min() >= 0, f"edit {number}"
        assert weights.max() <= 1, f"edit {number}"
