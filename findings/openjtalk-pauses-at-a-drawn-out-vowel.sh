#!/usr/bin/env bash
# pyopenjtalk-plus 0.4.1.post10 (MIT; Open JTalk with its dictionary, BSD), seen on 2026-11-30.
#
# Behaviour: Japanese draws a vowel out by `ー` or, as people speak in games and comics, by the wave dash `〜`. Open JTalk
# reads the first. The second is a pause within the word, or nothing: `え〜と` is "e", a pause and "to". The word is cut
# before it is read, so `は〜い` (yes) begins with "wa", as a particle does. Of the signs before a number `+` is read, and
# `-` is not: 5 degrees below zero are 5 degrees. `×` and `÷` are read, too.
#
# What a good engineer expects: a long vowel at both marks, and both signs of a number, or none.
# What to do: write `ー` for a wave dash after kana, マイナス for a minus sign, and から for a range.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pyopenjtalk-plus==0.4.1.post10
env/bin/python -W ignore - > log 2>&1 <<'PYTHON' || { cat log >&2; exit 1; }
from importlib.metadata import version
from pathlib import Path

import pyopenjtalk

lines = [f"pyopenjtalk-plus {version('pyopenjtalk-plus')}"]
for text in (
    "えーと", "え〜と", "はーい", "は〜い", "ありがとー", "ありがと〜", "3から5人", "3〜5人",
    "5度", "+5度", "-5度", "−5度", "5×3", "5÷3", "5−3",
):
    lines.append(f"{text} {pyopenjtalk.g2p(text)}")
Path("seen").write_text("\n".join(lines) + "\n", encoding="utf-8")
PYTHON
diff seen - <<'SEEN'
pyopenjtalk-plus 0.4.1.post10
えーと e e t o
え〜と e pau t o
はーい h a a i
は〜い w a pau i
ありがとー a r i g a t o o
ありがと〜 a r i g a t o
3から5人 s a N k a r a g o n i N
3〜5人 s a N pau g o n i N
5度 g o d o
+5度 t a s u g o d o
-5度 g o d o
−5度 g o d o
5×3 g o k a k e r u s a N
5÷3 g o w a r u s a N
5−3 g o pau s a N
SEEN
echo "as before: Open JTalk pauses at a wave dash, and leaves a minus sign out"
