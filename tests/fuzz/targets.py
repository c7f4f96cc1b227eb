"""Targets of the fuzz tests: every reader of the registries.

A target wants a sound file or two, in `seeds/GROUP/NAME/`; inputs that once failed are in
`corpus/GROUP/NAME/`. Targets of plug-ins are in `tests/plugins/fuzz`, with their files.
"""

from collections.abc import Callable, Iterator
from contextlib import chdir, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from unittest.mock import patch
from zlib import crc32

import numpy as np
from packs_tree import TREE, plant

from lipsync_lang import Performer, Schedule, resolve
from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_readers import ANIMATION_READERS as ANIMATIONS
from lipsync_lang.animations.writers.glb import write_glb
from lipsync_lang.authoring.language_draft import read_inventory
from lipsync_lang.base.errors import PackError
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.packs import finding
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import MODELS, Project, validation
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml import building
from lipsync_lang.packs.yaml.source import YamlSource
from lipsync_lang.production.builds import takes
from lipsync_lang.production.builds.script import read_script
from lipsync_lang.render.staging import staged
from lipsync_lang.reports.coverage.changes import read_document
from lipsync_lang.reports.quality.fitting import read_for
from lipsync_lang.schedules.timing_readers import TIMING_READERS as TIMINGS
from lipsync_lang.schedules.timing_readers import read_timings
from lipsync_lang.sound.speech.sound import read_audio
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.face_data import face_data
from lipsync_lang.text.lines.line_readers import LINE_READERS as LINES
from lipsync_lang.text.lines.line_readers import read_lines
from lipsync_lang.text.phonology.g2p.lexicon import read_lexicon
from lipsync_lang.text.phonology.g2p.orthography_profile import read_profile

HERE = Path(__file__).parent
PLUG_INS = HERE.parent / "plugins" / "fuzz"

LINE = Schedule.from_intervals(
    [("HH", 0.0, 0.08), ("AH", 0.08, 0.15), ("P", 0.15, 0.2), ("IY", 0.2, 0.4), ("_", 0.4, 0.9)],
    notation="arpabet",
)


@dataclass(frozen=True)
class Target:
    """A reader that receives damaged files.

    Parameters
    ----------
    name : GROUP/NAME, as its folders are called
    read : reads the file at a path
    place : where a file of a suffix lies in an empty folder
    share : how many inputs the target gets for one of another's; less where each takes long
    home : folder of its seeds and its corpus
    """

    name: str
    read: Callable[[Path], object]
    place: Callable[[Path, str], Path] = lambda folder, suffix: folder / f"line{suffix}"
    share: float = 1.0
    home: Path = HERE

    @property
    def seeds(self) -> list[Path]:
        """Valid files."""
        return _files(self.home / "seeds" / self.name)

    @property
    def corpus(self) -> list[Path]:
        """Inputs that failed in the past."""
        return _files(self.home / "corpus" / self.name)


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("*") if path.is_file())


@cache
def targets() -> dict[str, Target]:
    """Return all targets by name."""
    return {one.name: one for one in _found()}


def _found() -> Iterator[Target]:
    for name in TIMINGS.built_in():
        yield Target(f"timings/{name}", partial(_timings, name))
    for name in LINES.built_in():
        yield Target(f"lines/{name}", partial(_lines, name))
    yield Target("builds/script", _script)
    yield Target("builds/takes", _takes)
    for name in ANIMATIONS.built_in():
        yield Target(f"animations/{name}", lambda path: read_for(_performer(), path, LINE))
    for kind in MODELS:
        yield Target(f"packs/{kind}", _pack, partial(_placed, kind), share=0.2)
    yield Target("models/names", partial(read_model, bones=True))
    yield Target("models/written", _written)
    yield Target("models/drawn", _drawn)
    yield Target("sound/recording", read_audio)
    yield Target("words/lexicon", read_lexicon)
    yield Target("words/profile", read_profile)
    yield Target("words/inventory", lambda path: read_inventory(path, "1"))
    yield Target("words/coverage", read_document)
    if PLUG_INS.is_dir():  # the wing can be removed
        from plugins.fuzz.plug_in_targets import plug_in_targets

        yield from plug_in_targets()


@cache
def _performer() -> Performer:
    return resolve("english", "facefx")


# Timings and lines


def _timings(name: str, path: Path) -> None:
    try:
        read_timings(path, read_as=name)
    finally:
        read_timings(path)  # as the content and the suffix tell


def _lines(name: str, path: Path) -> None:
    del name  # the suffix tells
    for line in read_lines(path, remark=_plain):
        _plain(line.text)


def _script(path: Path) -> None:
    stated = {"kind": "project", "format": 1, "lines": path.name, "character": "facefx"}
    stated |= {"languages": ["english", "german"], "audio": "vo/{speaker}/{language}-{id}.wav"}
    outputs = ("takes/{language}/{character}/{id}.csv", "json:{speaker}-{language}{id}.json")
    with chdir(path.parent):
        data = stated | {"outputs": outputs}
        pack = Pack(Project.model_validate(data), (YamlSource(Path("lipsync.yaml"), data),))
        lines = read_script(pack, remark=lambda told: _plain(str(told)))
    made = [output for line in lines for _, output in line.outputs]
    assert len(set(made)) == len(made)
    for output in made:
        assert (path.parent / output).resolve().is_relative_to(path.parent.resolve())


def _takes(path: Path) -> None:
    """Read an archive as a build does, and play it; its checksums fit again, to get behind them."""
    content = bytearray(path.read_bytes())
    if len(content) >= takes.TAKES_HEADER.size:
        index, body = takes.TAKES_HEADER.unpack_from(content)[6:8]
        if body <= len(content) and index <= body:
            content[40:48] = len(content).to_bytes(8, "little")
            content[52:56] = crc32(content[body:]).to_bytes(4, "little")
            head = crc32(content[52:body], crc32(content[:48]))
            content[48:52] = head.to_bytes(4, "little")
            path.write_bytes(content)
    if find_spec("lipsync_lang.plugins"):  # the wing of plug-ins can be removed
        from lipsync_lang.plugins.players.takes import Archive, Player, TakesError

        with suppress(TakesError), Archive(path) as archive:
            player = Player(archive)
            for name in ("english/l1", "english/l2"):
                if player.play(name):
                    player.seek(0.1)
    takes.read_takes(path)


def _plain(text: str) -> None:
    assert isinstance(text, str)


# Packs

PLACES = {
    "phonemes": "languages/common.yaml",
    "ipa": "languages/ipa.yaml",
    "language": "languages/parent.yaml",
    "poseset": "posesets/face/poseset.yaml",
    "bank": "posesets/face/banks/common.yaml",
    "rig": "posesets/face/rigs/model.yaml",
    "character": "characters/anna.yaml",
    "project": "lipsync.yaml",
    "readout": "captures/readout.yaml",
}
"""File to damage in a valid tree of packs."""

assert PLACES["character"] in TREE


SCAN, VALIDATED = building.scan, validation.validated
KEPT_SCAN, KEPT_VALIDATED = cache(SCAN), cache(VALIDATED)
"""Sound packs beside the damaged one are read once, and their contents are kept."""


def _placed(kind: str, folder: Path, suffix: str) -> Path:
    del suffix
    if not (folder / PLACES[kind]).exists():
        plant(folder)
        (folder / PLACES[kind]).parent.mkdir(exist_ok=True)
    return folder / PLACES[kind]


def _pack(path: Path) -> None:
    root = next(one for one in path.parents if (one / "languages").is_dir())

    def scan(file: Path, content: bytes) -> YamlSource:
        return (SCAN if file.samefile(path) else KEPT_SCAN)(file, content)

    def validated(source: YamlSource, **expected: object) -> object:
        kept = VALIDATED if source.path.samefile(path) else KEPT_VALIDATED
        return kept(source, **expected)

    # the tree stands alone: no packs of the current folder, and none of the program
    with (
        chdir(root),
        patch.object(finding, "built_in", lambda: root),
        patch.object(building, "scan", scan),
        patch.object(validation, "validated", validated),
    ):
        for fault in validate(Library(project=None), [path]):
            assert fault.line >= 1
        for character in ("face", "anna"):
            with suppress(PackError):
                performer = resolve("parent", character, cache=False, gaps="rest")
                replace(performer, unknown="rest").perform(_moi(), fps=30)


@cache
def _moi() -> Schedule:
    return Schedule(("p", "a", "_"), np.array([0.0, 0.1, 0.3, 0.5]))


# Models


def _animation(path: Path) -> Animation:
    times = np.arange(4) / 10
    names = ("jawOpen", "x", "open")
    weights = np.linspace(0, 1, 12).reshape(4, 3)
    return Animation(times, names, weights, 10.0, LINE, model=path)


def _drawn(path: Path) -> None:
    scene = staged(_animation(path))
    assert np.isfinite(scene.points(0.15)).all()
    assert scene.moving.shape == (scene.count,)
    for one in scene.materials:
        assert one.texture is None or one.texture.ndim == 3
    shown = face_data(_animation(path), ArrayPack())
    assert shown.get("count", scene.count) == scene.count


def _written(path: Path) -> None:
    write_glb(_animation(path), BytesIO())
