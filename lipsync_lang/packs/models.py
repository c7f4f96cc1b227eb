"""The form of every kind of pack: one class, one sentence."""

from lipsync_lang.packs.check_models import Checks
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.forms import Pack
from lipsync_lang.packs.ipa_models import Ipa
from lipsync_lang.packs.language_models import (
    G2P,
    TTS,
    Hearing,
    Language,
    Phoneme,
    Phonemes,
    Rewrite,
    Sounds,
    Test,
    Visemes,
)
from lipsync_lang.packs.pose_models import (
    AtMost,
    Bank,
    Bigram,
    Channel,
    Character,
    Constraints,
    Contact,
    Delivery,
    Edit,
    Line,
    Motion,
    Pose,
    PoseSet,
    Rig,
    Target,
    Threshold,
    WordCurves,
)

__all__ = [
    "G2P",
    "MODELS",
    "TTS",
    "AtMost",
    "Bank",
    "Bigram",
    "Channel",
    "Character",
    "Checks",
    "Constraints",
    "Contact",
    "Delivery",
    "Edit",
    "Hearing",
    "Ipa",
    "Language",
    "Line",
    "Motion",
    "Pack",
    "Phoneme",
    "Phonemes",
    "Pose",
    "PoseSet",
    "Rewrite",
    "Rig",
    "Sounds",
    "Target",
    "Test",
    "Threshold",
    "Visemes",
    "WordCurves",
]

MODELS: dict[str, type[Pack]] = {
    "phonemes": Phonemes,
    "language": Language,
    "poseset": PoseSet,
    "bank": Bank,
    "character": Character,
    "rig": Rig,
    IPA: Ipa,
}
"""The model of each kind of pack."""
