#!/usr/bin/env bash
# panphon 0.22.2 (features of IPA segments; MIT), seen on 2026-11-28.
#
# Behaviour: `FeatureTable.ipa_segs` leaves out every segment that it does not know, and says nothing. It does
# not know the ASCII letter g (its own g is U+0261), the rhotic vowels U+025A and U+025D, the ligature U+02A6, and
# the prenasal mark. An affricate without a tie bar is two segments, one with it is one. `validate_word` tells of a
# segment that is missing, but not of the affricate.
#
# What a good engineer expects: an error, or a mark in the place of an unknown segment; `bɚd` with a vowel.
# What to do: normalise first (g, tie bars, ligatures), and compare the segments with the text.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check panphon==0.22.2
"$work/env/bin/python" -W ignore - > "$work/seen" 2> "$work/errors" <<'PYTHON' || { cat "$work/errors" >&2; exit 1; }
from importlib.metadata import version

import panphon

print("panphon", version("panphon"))
table = panphon.FeatureTable()
for word in ("ɡa", "ga", "bɚd", "bɝd", "t͡sa", "tsa", "ʦa", "ᵐba"):
    print(word, table.ipa_segs(word), table.validate_word(word))
PYTHON
diff "$work/seen" - <<'SEEN'
panphon 0.22.2
ɡa ['ɡ', 'a'] True
ga ['a'] False
bɚd ['b', 'd'] False
bɝd ['b', 'd'] False
t͡sa ['t͡s', 'a'] True
tsa ['t', 's', 'a'] True
ʦa ['a'] False
ᵐba ['b', 'a'] False
SEEN
echo "as before: panphon leaves out unknown segments in silence"
