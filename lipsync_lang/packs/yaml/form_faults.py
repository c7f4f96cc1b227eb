"""Codes of faults that one pack shows alone: its YAML and its form."""

from lipsync_lang.packs.yaml.fault_code import FaultCode

FORM_CODES: dict[str, FaultCode] = {
    # P0: the file as YAML
    "P001": FaultCode(
        "The file cannot be opened.",
        "The file is missing, is a folder, or you may not read it.",
        "Check the path and the rights of the file.",
    ),
    "P002": FaultCode(
        "The file is larger than any pack.",
        "Recorded data, or many languages in one file, make the pack too large.",
        "Split it into several packs.",
    ),
    "P003": FaultCode(
        "The file is not UTF-8 text.",
        "An editor saved the file in another encoding, such as UTF-16 or Latin-1.",
        'Save it as UTF-8. Most editors offer this under "Save as".',
    ),
    "P004": FaultCode(
        "The file starts with a byte order mark.",
        "An editor on Windows put an invisible mark before the first character.",
        "Save the file as UTF-8 without BOM.",
    ),
    "P005": FaultCode(
        "The file has a character that is not allowed in text.",
        "A control character was pasted into the text, or the file was damaged.",
        "Delete the character at the place of the fault, escaped or not.",
    ),
    "P006": FaultCode(
        "The file is empty.",
        "The file has no content, or only comments.",
        "Start it with `kind`, `format` and `name`, or delete it.",
    ),
    "P007": FaultCode(
        "A tab is used for indentation, where YAML needs spaces.",
        "The editor indents with tabs.",
        "Replace the tabs by spaces, and let the editor insert spaces in YAML files.",
    ),
    "P008": FaultCode(
        "The file is not valid YAML.",
        "A quote or bracket is open, a colon lacks its space, or an indentation differs.",
        "Correct this line or the one above. Put text with `: `, `#` or brackets into quotes.",
    ),
    "P009": FaultCode(
        "The file holds more than one document.",
        "A line `---` divides the file.",
        "Delete the line, or move the second part to a file of its own.",
    ),
    "P010": FaultCode(
        "The file nests deeper than any pack.",
        "A bracket is left open, so that each line nests deeper.",
        "Close the bracket.",
    ),
    "P011": FaultCode(
        "The file is larger than any pack, once its aliases are written out.",
        "Aliases (`*name`) repeat large values many times.",
        "Write fewer aliases, or split the pack.",
    ),
    "P012": FaultCode(
        "An alias has no anchor, or lies within an anchored value.",
        "The anchor is missing or misspelled, comes after its alias, or contains the alias.",
        "Write the value out in the place of the alias.",
    ),
    "P013": FaultCode(
        "A merge key (`<<`) is used.",
        "The pack merges fields of another mapping with `<<`.",
        "Write the fields out.",
    ),
    "P014": FaultCode(
        "A tag (`!`) is used.",
        "A value starts with `!`, or with a tag such as `!!python`.",
        "Delete the tag. If the value is text that starts with `!`, put it into quotes.",
    ),
    "P015": FaultCode(
        "A key is stated twice.",
        "The same key was added twice, often far from each other.",
        "Keep one of the two entries, and merge their values.",
    ),
    "P016": FaultCode(
        "A key is not plain text.",
        "A list or a mapping is in the place of a key, because a colon is missing or misplaced.",
        "Correct the colon. Put a key with special characters into quotes.",
    ),
    "P017": FaultCode(
        "The file asks for another version of YAML.",
        "A line `%YAML` asks for a version other than 1.2.",
        "Delete the line.",
    ),
    # P1: the form of one pack
    "P101": FaultCode(
        "A field is unknown.",
        "The field is misspelled, has the wrong indentation, or belongs to another kind.",
        "Take the name that the hint offers, or look for it in [packs](packs.md).",
    ),
    "P102": FaultCode(
        "A field is missing.",
        "Every pack of this kind needs the field.",
        "Add the field. [Packs](packs.md) lists the required fields.",
    ),
    "P103": FaultCode(
        "A value is of the wrong type.",
        "A plain value is a number, a truth value or null, or a list replaces a mapping.",
        "Put text such as `1.0` or `null` into quotes. Write a decimal point, not a comma.",
    ),
    "P104": FaultCode(
        "A number is out of range.",
        "The number is outside the range that the message states.",
        "Write a number within the range.",
    ),
    "P105": FaultCode(
        "A number is not finite.",
        "The number is infinite, or not a number (`.inf`, `.nan`).",
        "Write a plain number.",
    ),
    "P106": FaultCode(
        "A name or label is malformed.",
        "The name has a space, a capital or another character that is not allowed in it.",
        "Follow the message. A bigram is two common phonemes joined by a hyphen.",
    ),
    "P107": FaultCode(
        "A word is not one of the known words.",
        "The word is misspelled, or is not one of the choices of its field.",
        "Take one of the words that the message lists.",
    ),
    "P108": FaultCode(
        "A list has too few or too many items.",
        "The list has a different number of items from the one that its field needs.",
        "Add or remove items. The message states how many the field needs.",
    ),
    "P109": FaultCode(
        "The kind of pack is unknown, or does not belong here.",
        "The `kind` is misspelled, or the file lies in the folder of another kind.",
        "Correct `kind`, or move the file to its folder.",
    ),
    "P110": FaultCode(
        "The pack is in a newer format than this program reads.",
        "A newer version of the program wrote the pack.",
        "Update the program.",
    ),
    "P111": FaultCode(
        "The name of the pack differs from that of its file or folder.",
        "The file or its `name` was renamed, and the other was not.",
        "Rename one of the two.",
    ),
    "P112": FaultCode(
        "A bigram key has three or more parts, which are reserved for longer units.",
        "The key joins three or more common phonemes.",
        "Put three phonemes under `trigrams`. Draw longer sequences as bigrams.",
    ),
    "P113": FaultCode(
        "The times of a curve fall.",
        "The points of the curve are not in the order of time.",
        "Sort the points by time. Equal times are allowed.",
    ),
    "P114": FaultCode(
        "The shares of a phoneme's time do not fit its parts.",
        "The number of shares differs from the number of phonemes, or their sum is not 1.",
        "State one share for each phoneme, with a sum of 1.",
    ),
    "P115": FaultCode(
        "Fields of one entry contradict each other.",
        "Two fields of one entry cannot both hold.",
        "Remove one of the two, or correct it as the hint says.",
    ),
    "P116": FaultCode(
        "Text is empty.",
        "The field is present, but its text has no character.",
        "Write a value, or delete the field.",
    ),
    "P117": FaultCode(
        "A context of a rule is not a regular expression.",
        "A bracket or a sign of the regular expression is wrong.",
        "Correct the expression, and put a backslash before characters that stand for themselves.",
    ),
    "P118": FaultCode(
        "A context of a rule could take too long to match.",
        "The expression repeats something that repeats itself, such as `(a+)+`.",
        "Write it without nested or unbounded repetitions.",
    ),
}
"""Each code of a fault in the form of a pack."""
