"""Pydantic models of packs: one class per kind of pack or part of one."""

from typing import get_args

from lipsync_lang.packs.models.check_models import Checks
from lipsync_lang.packs.models.fields import PackModel
from lipsync_lang.packs.models.ipa_models import Decision, Ipa
from lipsync_lang.packs.models.language_models import (
    G2P,
    TTS,
    AudioFields,
    LabelCorrection,
    Language,
    Phoneme,
    Phonemes,
    Rewrite,
    Shade,
    SoundFields,
    Sounds,
    Test,
    Visemes,
)
from lipsync_lang.packs.models.pose_models import (
    AtMost,
    BankPack,
    BigramCurves,
    Character,
    Constraints,
    ContactRule,
    Delivery,
    Edit,
    LineEdits,
    MotionFields,
    PhonemeTarget,
    Pose,
    PoseSet,
    RigChannel,
    RigPack,
    Threshold,
    TrigramCurves,
    WordCurves,
)
from lipsync_lang.packs.models.project_models import Project
from lipsync_lang.packs.models.readout_models import ReadOut

__all__ = [
    "G2P",
    "MODELS",
    "TTS",
    "AtMost",
    "AudioFields",
    "BankPack",
    "BigramCurves",
    "Character",
    "Checks",
    "Constraints",
    "ContactRule",
    "Decision",
    "Delivery",
    "Edit",
    "Ipa",
    "LabelCorrection",
    "Language",
    "LineEdits",
    "MotionFields",
    "PackModel",
    "Phoneme",
    "PhonemeTarget",
    "Phonemes",
    "Pose",
    "PoseSet",
    "Project",
    "ReadOut",
    "Rewrite",
    "RigChannel",
    "RigPack",
    "Shade",
    "SoundFields",
    "Sounds",
    "Test",
    "Threshold",
    "TrigramCurves",
    "Visemes",
    "WordCurves",
]

MODELS: dict[str, type[PackModel]] = {
    get_args(model.model_fields["kind"].annotation)[0]: model
    for model in (Phonemes, Language, PoseSet, BankPack, Character, RigPack, Ipa, Project, ReadOut)
}
"""The model of each kind of pack, keyed by the value of its `kind` field."""
