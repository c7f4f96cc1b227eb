"""Pydantic models of packs: one class per kind of pack or part of one."""

from typing import get_args

from lipsync_lang.packs.models.check_models import Checks, ReadOut
from lipsync_lang.packs.models.fields import PackModel
from lipsync_lang.packs.models.gesture_models import Gesture, GesturePose, GestureWords
from lipsync_lang.packs.models.ipa_models import Decision, Ipa
from lipsync_lang.packs.models.language_models import (
    USUAL,
    Language,
    Phonemes,
    Shade,
    SoundFields,
    Sounds,
)
from lipsync_lang.packs.models.motion_models import MotionFields
from lipsync_lang.packs.models.pose_models import (
    AtMost,
    BankPack,
    BigramCurves,
    Character,
    Constraints,
    ContactRule,
    Delivery,
    LineEdits,
    PhonemeTarget,
    Pose,
    PoseSet,
    Threshold,
    TrigramCurves,
)
from lipsync_lang.packs.models.project_models import Project
from lipsync_lang.packs.models.rig_models import RigChannel, RigPack

__all__ = [
    "MODELS",
    "USUAL",
    "AtMost",
    "BankPack",
    "BigramCurves",
    "Character",
    "Checks",
    "Constraints",
    "ContactRule",
    "Decision",
    "Delivery",
    "Gesture",
    "GesturePose",
    "GestureWords",
    "Ipa",
    "Language",
    "LineEdits",
    "MotionFields",
    "PackModel",
    "PhonemeTarget",
    "Phonemes",
    "Pose",
    "PoseSet",
    "Project",
    "ReadOut",
    "RigChannel",
    "RigPack",
    "Shade",
    "SoundFields",
    "Sounds",
    "Threshold",
    "TrigramCurves",
]

MODELS: dict[str, type[PackModel]] = {
    get_args(model.model_fields["kind"].annotation)[0]: model
    for model in (Phonemes, Language, PoseSet, BankPack, Character, RigPack, Ipa, Project, ReadOut)
}
"""The model of each kind of pack, keyed by the value of its `kind` field."""
