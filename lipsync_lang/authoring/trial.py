"""Runs of the tests in a language pack, through the same engine as any other text.

A test is a text with its expected common phonemes; a mismatch is a fault with a location.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError, PackError, SpeechError, did_you_mean
from lipsync_lang.packs import models
from lipsync_lang.packs.extending import test_fault
from lipsync_lang.packs.finding import FOLDERS, IPA, SHARED, built_in
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.resolver.language_tables import manner_of, notations_of
from lipsync_lang.resolver.nearest_phonemes import among, fights
from lipsync_lang.sound.speech import ENGINES
from lipsync_lang.sound.speech.hearing.align.pocketsphinx_aligner import (
    PocketsphinxAligner,
    models_of,
)
from lipsync_lang.sound.speech.hearing.alignment import aligners
from lipsync_lang.sound.speech.hearing.recognise.pocketsphinx_recogniser import (
    PocketsphinxRecogniser,
)
from lipsync_lang.sound.speech.hearing.recognition import chosen_recogniser
from lipsync_lang.sound.speech.speaking.speaker import KnownReadings, Speaker
from lipsync_lang.sound.speech.speaking.transcripts import Transcript
from lipsync_lang.text.phonology.g2p.g2p_engines import Rule
from lipsync_lang.text.phonology.g2p.rules import Rewriter
from lipsync_lang.text.phonology.g2p.tokens import pieces
from lipsync_lang.text.phonology.labels import normalise


@dataclass(frozen=True)
class Trial:
    """Result of the tests of a pack: a transcript each, in order, or the reason of a refusal.

    The shades of the common phonemes pass for their parents.
    """

    pack: Pack[models.Language]
    transcripts: tuple[Transcript, ...] = ()
    refusal: str = ""
    shades: Mapping[str, models.Shade] = field(default_factory=dict)

    def faults(self, silence: str) -> Iterator[Fault]:
        """Yield a fault per failed test, with its location in the pack."""
        tts = self.pack.model.tts
        if tts is not None and tts.engine not in ENGINES:
            hint = did_you_mean(tts.engine, ENGINES)
            what = f"unknown speech engine '{tts.engine}'"
            yield self.pack.fault(("tts", "engine"), "P115", what, hint)
        if self.refusal:
            what, hint = "its tests could not be run", self.refusal
            yield self.pack.warning(("tests",), "W310", what, hint, key=True)
        # Not strict: a refusal leaves tests without transcripts.
        pairs = zip(self.pack.model.tests, self.transcripts, strict=False)
        for index, (test, heard) in enumerate(pairs):
            said = [name for name in heard.phonemes if name != silence]
            if heard.unmapped:
                labels = ", ".join(f"'{label}'" for label in heard.unmapped)
                what = f"'{test.text}' has {labels}, which the pack does not map"
                hint = f"map it under `notations: {heard.notation}`"
                yield test_fault(self.pack, index, what, hint)
            elif heard.unread and heard.advice:
                what = f"'{test.text}' has {' '.join(heard.unread)}, which is not read"
                yield test_fault(self.pack, index, what, *heard.advice)
            elif not test.accepts(said, self.shades, read=True):
                wanted = " ".join(test.read or test.phonemes)
                what = f"'{test.text}' becomes {' '.join(said)}, not {wanted}"
                hint = f"the engine read {' '.join(heard.labels)}; correct the map or the test"
                yield test_fault(self.pack, index, what, hint)

    @property
    def reached(self) -> set[str]:
        """Normalised labels of the tests, from the engine and from the stated IPA."""
        read = {normalise(label) for heard in self.transcripts for label in heard.labels}
        stated = {normalise(s) for test in self.pack.model.tests for s in test.ipa.split()}
        return read | stated

    def silent_rules(self) -> list[int]:
        """Return the indices of rules without effect in any test."""
        g2p = self.pack.model.g2p
        if g2p is None or not g2p.rules:
            return []
        rules = [Rule(r.spelling, r.to, r.before, r.after) for r in g2p.rules]
        rewriter = Rewriter(rules)
        texts = [test.text for test in self.pack.model.tests]
        # Rules see the spelling that a respeller made, not the one of the test.
        texts += (word.respelled for heard in self.transcripts for word in heard.words)
        words = (piece.text for text in texts for piece in pieces(text))
        fired = {number for word in words for number, _, _ in rewriter.steps(word)}
        return [number for number in range(len(rules)) if number not in fired]


def try_out(
    library: Library, pack: Pack[models.Language], read: "KnownReadings | None" = None
) -> Trial:
    """Run the tests of a language through its engine; `read` is that of `Speaker`."""
    if not pack.model.tests:
        return Trial(pack)
    try:
        common = library.common().model
        speaker = Speaker(manner_of(pack, common), notations_of(library, pack), read=read)
        texts = [test.text for test in pack.model.tests]
        return Trial(pack, tuple(speaker.transcribe(texts)), shades=common.shades)
    except LipsyncError as error:
        return Trial(pack, refusal=str(error).splitlines()[0])


def doubts(library: Library, pack: Pack[models.Language]) -> Iterator[Fault]:
    """Yield a warning per mapping that contradicts the features and has no stated reason."""
    for label, features in fights(pack.model, among(library, pack)):
        becomes = " ".join(pack.model.notations[IPA][label].to) or "(mute)"
        what = f"'{label}' becomes {becomes}, which contradicts its features: {', '.join(features)}"
        hint = "correct it, or give the reason under `reasons`"
        yield pack.warning(("notations", IPA, label), "W309", what, hint, key=True)


def unheard(library: Library, pack: Pack[models.Language]) -> Iterator[Fault]:
    """Yield a fault per engine or model of `audio` for which a recording would be refused.

    Where pocketsphinx is not installed, nothing is known of its models.
    """
    if pack.model.audio is None or find_spec("pocketsphinx") is None:
        return
    try:
        speaker = Speaker(manner_of(pack, library.common().model), notations_of(library, pack))
    except LipsyncError:  # other faults say why
        return
    asked: dict[str, Callable[[], Sequence[tuple[object, str | None]]]] = {
        "align": lambda: [one[1:] for one in aligners(speaker, None)]
    }
    if pack.model.audio.recognise is not None:
        asked["recognise"] = lambda: [chosen_recogniser(speaker, None)]
    for named, ask in asked.items():
        try:
            for engine, model in ask():
                if isinstance(engine, PocketsphinxAligner | PocketsphinxRecogniser):
                    models_of(model)
        except SpeechError as error:
            what, _, hint = str(error).partition("; ")
            place = "model" if f"'{pack.model.audio.model}'" in what else named
            yield pack.fault(("audio", place), "P239", what, hint)


def languages_in(library: Library, paths: Sequence[Path] = ()) -> Iterator[Pack[models.Language]]:
    """Yield the valid language packs of paths; by default all except the built-in ones."""
    named = library.names("language") if not paths else ()
    files = [found.path for found in named if found.root.path != built_in()]
    for path in paths:
        absolute = path.absolute()
        inner = absolute / FOLDERS["language"]
        folder = inner if inner.is_dir() else absolute
        found = sorted(folder.glob("*.yaml")) if absolute.is_dir() else [absolute]
        in_place = (f for f in found if f.parent.name == FOLDERS["language"])
        files += [file for file in in_place if file.stem not in SHARED]
    for file in files:
        with suppress(PackError):
            yield library.extended(file)
