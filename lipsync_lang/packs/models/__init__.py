"""Pydantic models of packs: one class per kind of pack or part of one."""

from typing import get_args

from lipsync_lang.packs.models.check_models import Checks as Checks
from lipsync_lang.packs.models.check_models import ReadOut as ReadOut
from lipsync_lang.packs.models.fields import PackModel as PackModel
from lipsync_lang.packs.models.gesture_models import Gesture as Gesture
from lipsync_lang.packs.models.gesture_models import GesturePose as GesturePose
from lipsync_lang.packs.models.gesture_models import GestureWords as GestureWords
from lipsync_lang.packs.models.ipa_models import Decision as Decision
from lipsync_lang.packs.models.ipa_models import Ipa as Ipa
from lipsync_lang.packs.models.language_models import MOUTH_MEASURES as MOUTH_MEASURES
from lipsync_lang.packs.models.language_models import USUAL as USUAL
from lipsync_lang.packs.models.language_models import Language as Language
from lipsync_lang.packs.models.language_models import Phonemes as Phonemes
from lipsync_lang.packs.models.language_models import Shade as Shade
from lipsync_lang.packs.models.language_models import SoundFields as SoundFields
from lipsync_lang.packs.models.language_models import SoundMouth as SoundMouth
from lipsync_lang.packs.models.language_models import Sounds as Sounds
from lipsync_lang.packs.models.motion_models import MotionFields as MotionFields
from lipsync_lang.packs.models.pose_models import AtMost as AtMost
from lipsync_lang.packs.models.pose_models import BankPack as BankPack
from lipsync_lang.packs.models.pose_models import BigramCurves as BigramCurves
from lipsync_lang.packs.models.pose_models import Character as Character
from lipsync_lang.packs.models.pose_models import Constraints as Constraints
from lipsync_lang.packs.models.pose_models import ContactRule as ContactRule
from lipsync_lang.packs.models.pose_models import Delivery as Delivery
from lipsync_lang.packs.models.pose_models import LineEdits as LineEdits
from lipsync_lang.packs.models.pose_models import PhonemeTarget as PhonemeTarget
from lipsync_lang.packs.models.pose_models import Pose as Pose
from lipsync_lang.packs.models.pose_models import PoseSet as PoseSet
from lipsync_lang.packs.models.pose_models import SpokenEdits as SpokenEdits
from lipsync_lang.packs.models.pose_models import Threshold as Threshold
from lipsync_lang.packs.models.pose_models import TrigramCurves as TrigramCurves
from lipsync_lang.packs.models.project_models import Project as Project
from lipsync_lang.packs.models.rig_models import RigChannel as RigChannel
from lipsync_lang.packs.models.rig_models import RigPack as RigPack

MODELS: dict[str, type[PackModel]] = {
    get_args(model.model_fields["kind"].annotation)[0]: model
    for model in (Phonemes, Language, PoseSet, BankPack, Character, RigPack, Ipa, Project, ReadOut)
}
"""The model of each kind of pack, keyed by the value of its `kind` field."""
