#!/usr/bin/env bash
# phonemizer 3.4.0 (GPL-3) with segments 2.4.0 (Apache-2.0), seen on 2026-11-28.
#
# Behaviour: the backend `segments` is built on the package of that name, whose orthography profiles are tables with
# named columns, as in CLDF. But phonemizer reads the file itself, as two words a line. The header is a rule (the text
# "Grapheme" sounds as "IPA"), the NULL of a silent letter is a sound called NULL, two sounds in a cell are refused,
# and so is a third column, even one without a meaning for the sounds.
#
# What a good engineer expects: a profile that segments reads is one that phonemizer reads.
# What to do: read the profile by its columns, and write a file of two words a line for phonemizer.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check 'phonemizer[segments]==3.4.0' segments==2.4.0
cd "$work"
"$work/env/bin/python" - > seen 2> errors <<'PYTHON' || { cat errors >&2; exit 1; }
from importlib.metadata import version
from pathlib import Path

from phonemizer.backend import SegmentsBackend
from phonemizer.separator import Separator
from segments import Profile, Tokenizer

print("phonemizer", version("phonemizer"), "segments", version("segments"))
Path("plain.tsv").write_text("Grapheme\tIPA\nch\ttʃ\nh\tNULL\na\ta\n", encoding="utf-8")
Path("double.tsv").write_text("Grapheme\tIPA\nx\tk s\na\ta\n", encoding="utf-8")
Path("third.tsv").write_text("Grapheme\tIPA\tExample\na\ta\tama\n", encoding="utf-8")
for name, text in (("plain.tsv", "cha ha Grapheme"), ("double.tsv", "xa"), ("third.tsv", "a")):
    told = Tokenizer(Profile.from_file(name))(text.removesuffix(" Grapheme"), column="IPA")
    print(name, "segments:", told)
    try:
        read = SegmentsBackend(name).phonemize([text], separator=Separator(phone=" ", word=" | "))
        print(name, "phonemizer:", read[0].strip())
    except RuntimeError as error:
        print(name, "phonemizer:", str(error).partition(": ")[0])
PYTHON
diff seen - <<'SEEN'
phonemizer 3.4.0 segments 2.4.0
plain.tsv segments: tʃ a # a
plain.tsv phonemizer: tʃ a  | NULL a  | IPA  |
double.tsv segments: k s a
double.tsv phonemizer: grapheme to phoneme file, line 2 must have 2 rows but have 3
third.tsv segments: a
third.tsv phonemizer: grapheme to phoneme file, line 1 must have 2 rows but have 3
SEEN
echo "as before: phonemizer takes no profile with columns"
