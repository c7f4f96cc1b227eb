"""Codes of faults that a pack shows beside other packs, and of warnings."""

from lipsync_lang.packs.yaml.fault_code import FaultCode

REFERENCE_CODES: dict[str, FaultCode] = {
    # P2: references between packs
    "P201": FaultCode(
        "A pose is unknown to the pose set.",
        "The name of the pose is misspelled, or is a pose of another pose set.",
        "Take a pose that `lipsync-lang posesets show NAME` lists, or add the pose.",
    ),
    "P202": FaultCode(
        "A common phoneme is unknown.",
        "The label is misspelled, or is a label of the language, not a common phoneme.",
        "Take a common phoneme, or add a new one under `adds` of the language.",
    ),
    "P203": FaultCode(
        "A pose set is unknown.",
        "The pose set is misspelled, or its folder is not among the folders of packs.",
        "Take a name that `lipsync-lang posesets` lists, or give the folder with `--path`.",
    ),
    "P204": FaultCode(
        "A bank or rig belongs to another pose set.",
        "The file was copied from the folder of another pose set.",
        "Move it to the folder of its pose set, or correct its `poseset`.",
    ),
    "P205": FaultCode(
        "An entry appears twice in a list.",
        "The entry was added twice, or an alternative spelling of it is already in the list.",
        "Keep one of the two.",
    ),
    "P206": FaultCode(
        "Constraints form a circle.",
        "Each pose of the circle depends on the next, so that no order is right.",
        "Remove one constraint of the circle.",
    ),
    "P207": FaultCode(
        "A contact pose has to yield to another pose.",
        "The order of `priority` puts another pose before a pose that a contact holds.",
        "Put the contact pose last of the two in `priority`, or remove the constraint.",
    ),
    "P208": FaultCode(
        "A constraint keeps two contact poses below their floors.",
        "The threshold of the two poses is lower than the sum of their floors.",
        "Raise the threshold, or lower the floors.",
    ),
    "P209": FaultCode(
        "A pose has a ceiling below the floor that a contact gives it.",
        "Two contacts of the same phoneme disagree about the pose.",
        "Remove the pose from one of the contacts.",
    ),
    "P210": FaultCode(
        "A language is unknown.",
        "The name, tag or alias is misspelled, or the pack is not among the folders of packs.",
        "Take a name that `lipsync-lang languages` lists, or give the folder with `--path`.",
    ),
    "P211": FaultCode(
        "Languages extend each other in a circle.",
        "The `extends` fields of the languages lead back to the first one.",
        "Remove `extends` from one of them.",
    ),
    "P212": FaultCode(
        "A rig is unknown.",
        "The rig is misspelled, or belongs to another pose set.",
        "Take a name that `lipsync-lang posesets show NAME` lists, or add the rig.",
    ),
    "P213": FaultCode(
        "A file that a pack names is missing.",
        "The file was moved or renamed, or its path is not relative to the pack.",
        "Put the file beside the pack, or correct its path.",
    ),
    "P214": FaultCode(
        "A channel is unknown to the rig.",
        "The channel is misspelled, or the rig does not drive it.",
        "Take one of the rig's channels, or add the channel.",
    ),
    "P215": FaultCode(
        "A phoneme of the common pack is declared again.",
        "`adds` has the label of a phoneme or shade that all languages share.",
        "Choose another label, or write `LABEL: null` if you add an existing phoneme unchanged.",
    ),
    "P216": FaultCode(
        "A pair of poses is constrained twice, or a pose with itself.",
        "The pair is listed in both orders, or names one pose two times.",
        "Keep one entry with two different poses.",
    ),
    "P217": FaultCode(
        "A notation is unknown to the language.",
        "The notation is misspelled, or the language has no map of it.",
        "Take one of the language's notations, or add the notation under `notations`.",
    ),
    "P218": FaultCode(
        "A label is not in the expected notation.",
        "The label is misspelled, or belongs to another notation.",
        "Correct the label, or map it under `notations`.",
    ),
    "P219": FaultCode(
        "Two labels of a notation have the same spelling, but different mappings.",
        "The labels differ only in case, composed characters or marks without a meaning.",
        "Keep one of the two.",
    ),
    "P220": FaultCode(
        "A phoneme of the inventory is neither mapped nor listed as absent.",
        "The inventory names a sound that the language does not map.",
        "Map the sound, or give the reason under `inventory: absent`.",
    ),
    "P221": FaultCode(
        "A test of a language fails.",
        "The engine, the rules or the map gives other phonemes than the test states.",
        "Run `lipsync-lang transcribe` with the word, and correct the map, the word or the test.",
    ),
    "P222": FaultCode(
        "A feature, or a word that describes letters, is unknown to the IPA pack.",
        "The word or feature is misspelled, or the IPA pack does not define it.",
        "Take a word of the hint, or of `languages/ipa.yaml`.",
    ),
    "P223": FaultCode(
        "A letter or mark is unknown to the IPA pack.",
        "The symbol is not IPA, or the IPA pack does not define it.",
        "Correct the symbol, or add it under `letters` or `marks`.",
    ),
    "P224": FaultCode(
        "Two poses have the same shape name of a model.",
        "Two poses list the same name under their spellings.",
        "Give the name to one pose.",
    ),
    "P225": FaultCode(
        "The face at rest has the name of a pose.",
        "`neutral` repeats the name of a pose.",
        "Rename one of the two, or remove the pose.",
    ),
    "P226": FaultCode(
        "A voice is unknown to its speech engine.",
        "The voice is misspelled, or the installed engine is too old to have it.",
        "Take a voice that `lipsync-lang voices` lists.",
    ),
    "P227": FaultCode(
        "The parent of a shade is a shade.",
        "`like` names another shade.",
        "Name the phoneme that the other shade is like.",
    ),
    "P230": FaultCode(
        "A region is unknown to the pose set.",
        "The region is misspelled, or is a region of another pose set.",
        "Take a region that `lipsync-lang posesets show NAME` lists.",
    ),
    "P231": FaultCode(
        "A measure is unknown to the pose set.",
        "A check or a rule names a measure that the pose set does not define.",
        "State the measure under `measures` of the pose set, or correct the name.",
    ),
    # W3: valid, but probably a mistake
    "W301": FaultCode(
        "A pose has no target, so drafts never move it.",
        "The pose set has no target of any phoneme for this pose.",
        "Name the pose under `targets`. If only drawn bigrams move it, leave it so.",
    ),
    "W302": FaultCode(
        "A constraint links two poses of equal priority, so neither yields.",
        "`priority` names neither pose, or both in one rank.",
        "Name the pose that yields in `priority`.",
    ),
    "W303": FaultCode(
        "A file in a folder of packs is not read.",
        "The suffix is not `.yaml`, or a folder has no pose set in it.",
        "Rename the file, move it elsewhere, or write the missing pack.",
    ),
    "W304": FaultCode(
        "An installed distribution offers packs that cannot be found.",
        "The distribution was removed or moved in part.",
        "Install it again, or uninstall it.",
    ),
    "W305": FaultCode(
        "Two languages have the same tag or alias, so it always finds the first one.",
        "Two packs state the same tag or alias.",
        "Change the tag or alias of one of them.",
    ),
    "W306": FaultCode(
        "The curve of a bigram misses the contact of its phoneme.",
        "Somebody drew the curve lower than the floor of the contact.",
        "Raise the curve, or state `contact: free` if the lips may miss each other there.",
    ),
    "W307": FaultCode(
        "A rule never fires, because an earlier one takes its letters.",
        "A rule above it matches the same letters in the same context.",
        "Put the more specific rule first.",
    ),
    "W308": FaultCode(
        "An entry cannot be reached, or has no effect.",
        "Another entry has the same effect, or the entry names a missing thing.",
        "Correct the name, or delete the entry.",
    ),
    "W309": FaultCode(
        "A mapping contradicts the features of its sound.",
        "The map gives a sound a mouth that its features do not suggest.",
        "Correct the map, or give the reason under `reasons`.",
    ),
    "W310": FaultCode(
        "The tests of a language could not be run.",
        "The engine that reads this language is not installed.",
        "Install the extra that the message names, and validate again.",
    ),
    "W311": FaultCode(
        "A pose drives no channel of a rig, and the rig does not list it as lost.",
        "The model has nothing that shows the pose.",
        "Drive a channel with the pose, or give the reason under `lost`.",
    ),
    "W312": FaultCode(
        "A contact has no effect.",
        "The contact has neither a floor above 0 nor a ceiling below 1.",
        "State one of them, or remove the contact.",
    ),
    "W313": FaultCode(
        "A threshold is never reached, so it has no effect.",
        "Targets and banks never raise the two poses so far.",
        "Lower the threshold, or remove the pair.",
    ),
    "W314": FaultCode(
        "A target disagrees with a contact of its phoneme.",
        "The target of a phoneme is below the floor or above the ceiling of its contact.",
        "Change the target or the contact, so that a draft satisfies it.",
    ),
    "W320": FaultCode(
        "No bank has the requested style.",
        "The character or the project names a style that no bank has.",
        "Write a bank with `style`, or correct the name.",
    ),
}
"""Each code of a fault between packs, and of a warning."""
