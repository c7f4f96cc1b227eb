"""The form of every kind of pack: one class, one sentence."""

from typing import get_args

from lipsync_lang.packs.models.check_models import Checks
from lipsync_lang.packs.models.fields import Pack
from lipsync_lang.packs.models.ipa_models import Ipa
from lipsync_lang.packs.models.language_models import (
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
from lipsync_lang.packs.models.pose_models import (
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
    get_args(model.model_fields["kind"].annotation)[0]: model
    for model in (Phonemes, Language, PoseSet, Bank, Character, Rig, Ipa)
}
"""The model of each kind of pack, by the one value that its `kind` may have."""
