#!/usr/bin/env bash
# praatio 6.2.2 (MIT), praat-textgrids 1.4.0 (GPL-3) and tgt 1.5 (GPL-3) against Praat itself, by praat-parselmouth 0.4.7
# (GPL-3), seen on 2026-11-30.
#
# Behaviour: Praat doubles a quote in a label. praatio undoes that in intervals, but not in points, and doubles it again when
# it saves: a tone `"H` has two quotes after one pass, four after two. praat-textgrids leaves doubled quotes within a label,
# and takes away those at its ends: the stressed vowel `"a` of SAMPA becomes `a`. At ` = ` it cuts a label, and tgt loses
# the whole label. All three read the rest of the file, and say nothing.
#
# What a good engineer expects: the labels that Praat shows, in tiers of both kinds, and a file that stays as it is.
# What to do: write stress as IPA, keep quotes out of points, and compare the labels after a pass.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check \
  praatio==6.2.2 praat-textgrids==1.4.0 tgt==1.5 praat-parselmouth==0.4.7
env/bin/python - > seen 2> errors <<'PYTHON' || { cat errors >&2; exit 1; }
import textgrids
import tgt
from parselmouth import read
from parselmouth.praat import call
from praatio import textgrid

PHONES, TONES = ('"a', 'n=', 'a"n=', "a = b"), ('"H',)


def by_praat(path):
    grid = read(path)
    phones = [call(grid, "Get label of interval", 1, at) for at in range(1, len(PHONES) + 1)]
    return phones, [call(grid, "Get label of point", 2, 1)]


def by_praatio(path):
    grid = textgrid.openTextgrid(path, includeEmptyIntervals=True)
    return tuple([entry.label for entry in grid.getTier(name).entries] for name in ("phones", "tones"))


def by_praat_textgrids(path):
    grid = textgrids.TextGrid(path)
    return tuple([str(entry.text) for entry in grid[name]] for name in ("phones", "tones"))


def by_tgt(path):
    grid = tgt.io.read_textgrid(path, include_empty_intervals=True)
    return tuple([entry.text for entry in grid.get_tier_by_name(name)] for name in ("phones", "tones"))


grid = call("Create TextGrid", 0, len(PHONES), "phones tones", "tones")
for at, phone in enumerate(PHONES, 1):
    if at > 1:
        call(grid, "Insert boundary", 1, at - 1)
    call(grid, "Set interval text", 1, at, phone)
call(grid, "Insert point", 2, 0.5, *TONES)
call(grid, "Save as text file", "made.TextGrid")
for reader in (by_praat, by_praatio, by_praat_textgrids, by_tgt):
    phones, tones = reader("made.TextGrid")
    print(reader.__name__, "phones", *map(repr, phones), "tones", *map(repr, tones))
for count in (1, 2):
    textgrid.openTextgrid("made.TextGrid", includeEmptyIntervals=True).save(
        "made.TextGrid", format="long_textgrid", includeBlankSpaces=True)
    phones, tones = by_praat("made.TextGrid")
    print(f"saved {count} times, by_praat phones", *map(repr, phones), "tones", *map(repr, tones))
PYTHON
diff seen - <<'SEEN'
by_praat phones '"a' 'n=' 'a"n=' 'a = b' tones '"H'
by_praatio phones '"a' 'n=' 'a"n=' 'a = b' tones '""H'
by_praat_textgrids phones 'a' 'n=' 'a""n=' 'a' tones 'H'
by_tgt phones '"a' 'n=' 'a"n=' '' tones '"H'
saved 1 times, by_praat phones '"a' 'n=' 'a"n=' 'a = b' tones '""H'
saved 2 times, by_praat phones '"a' 'n=' 'a"n=' 'a = b' tones '""""H'
SEEN
echo "as before: readers of TextGrids change labels with quotes and equals signs"
