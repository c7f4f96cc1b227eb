"""A small, valid set of packs to break, in an invented language."""

from pathlib import Path

COMMON = """\
kind: phonemes
format: 1
name: common
silence: _
silence_labels: ["", sil, "<p:>"]
phonemes:
  _: {title: silence, class: silence}
  p: {title: lips pressed, ipa: [p, b, m], example: put, class: stop}
  f: {ipa: [f], class: fricative}
  a: {ipa: [a], class: vowel}
  yu: {title: front rounded, like: a, class: vowel}
base: [p, f, a]
"""

PARENT = """\
kind: language
format: 1
name: parent
tag: qaa
title: Parent
adds: [yu]
g2p: {engine: rules, rules: [{from: m, to: P}, {from: h, to: [], before: "[ao]"}]}
tts: {engine: espeak, voice: eo}
durations: {vowel: 0.1, stop: 0.07}
silence: [pau]
notations:
  first: {P: p, Y: yu, 2: a, "~": a, no: [f, a]}
  ipa:
    ts: {to: [p, f], shares: [0.4, 0.6]}
words: {moi: [p, a]}
examples: {P: moi}
reasons: {Y: rounded}
tests:
  - {text: moi, phonemes: [p, a], source: nobody}
"""

CHILD = """\
kind: language
format: 1
name: child
tag: qaa-XX
extends: parent
notations:
  first:
    P: f
  own: {x: yu}
words: {moi: [f]}
"""

POSESET = """\
kind: poseset
format: 1
name: face
title: Face
poses:
  open: {title: jaw open, region: jaw}
  PBM: {title: lips pressed}
  FV: {}
  wide:
constraints:
  default: 2.0
  pairs:
    - {between: [open, PBM], threshold: 0.5}
    - {pose: wide, at_most: open}
priority: [open, FV, PBM]
contacts:
  lips: {phonemes: [p], floor: {PBM: 0.9}, ceiling: {open: 0.1}}
  teeth: {phonemes: [f], floor: {FV: 0.8}}
motion: {stitch: max, window: 0.13, speed_limit: 15}
targets:
  p: {PBM: 1.0, dominance: {PBM: 6, open: 6}}
  f: {FV: 0.9}
  a: [{open: 0.45, wide: 0.1}, {open: 0.25}]
measures: {aperture: {open: 1, PBM: -1}}
"""

BANK = """\
kind: bank
format: 1
name: common
poseset: face
language: null
bigrams:
  f-a: {boundary: 0.4, curves: {FV: [[0, 0], [0.2, 1], [0.6, 0]], open: [[0.2, 0], [1, 0]]}}
  p-yu:
    status: approved
    contact: free
    curves: {}
"""

RIG = """\
kind: rig
format: 1
name: model
poseset: face
channels:
  jawOpen: {gains: {open: 0.7}, range: [0, 1]}
  lips: {gains: {PBM: 0.6}, at_most: jawOpen}
  jaw: {node: Jaw, rotation: [1, 0, 0], gains: {open: 18}}
names: {jawOpen: [Jaw_Open, JAW_OPEN]}
lost: {FV: no lower lip, wide: no corners}
"""

CHARACTER = """\
kind: character
format: 1
name: anna
poseset: face
bigrams: {f-a: {curves: {}}}
banks: [anna-bank.yaml]
words: {moi: {curves: {open: [[0, 0], [1, 1]]}}}
lines: {intro_042: {edits: [{word: 0, phoneme: 1, curves: {open: [[0, 0], [1, 0]]}}]}}
motion: {speed_limit: 12}
rig: model
"""

ANNAS_BANK = """\
kind: bank
format: 1
name: anna-bank
poseset: face
bigrams:
  a-f: {curves: {FV: [[0, 0], [1, 1]]}}
"""

TREE = {
    "languages/common.yaml": COMMON,
    "languages/parent.yaml": PARENT,
    "languages/child.yaml": CHILD,
    "posesets/face/poseset.yaml": POSESET,
    "posesets/face/banks/common.yaml": BANK,
    "posesets/face/rigs/model.yaml": RIG,
    "characters/anna.yaml": CHARACTER,
    "characters/anna-bank.yaml": ANNAS_BANK,
}


def plant(root: Path, *without: str) -> Path:
    """Write the valid packs into a folder, except some files."""
    for name, text in TREE.items():
        if name not in without:
            put(root, name, text)
    return root


def put(root: Path, name: str, text: str | bytes) -> Path:
    """Write one file below a folder."""
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path
