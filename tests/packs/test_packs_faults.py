"""Every fault of packs: its code, and the exact place in the report."""

import json
import re
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import pytest
from lanes import full
from packs_tree import TREE, plant, put

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import MODELS
from lipsync_lang.packs.models.language_models import ALIAS_PATTERN, TAG_PATTERN
from lipsync_lang.packs.models.validation import _words
from lipsync_lang.packs.yaml.faults import Fault, PackFaults, fault_codes
from lipsync_lang.packs.yaml.pack_files import MAX_PACK_BYTES

COMMON = "languages/common.yaml"
PARENT = "languages/parent.yaml"
CHILD = "languages/child.yaml"
POSESET = "posesets/face/poseset.yaml"
BANK = "posesets/face/banks/common.yaml"
RIG = "posesets/face/rigs/model.yaml"
ANNA = "characters/anna.yaml"


@dataclass(frozen=True)
class Bad:
    """A change to a valid pack: the old and the new text, and all resulting faults.

    A fault is (code, line, place) in the changed file, the place being a column or the text that
    starts there; `old` None adds or replaces the whole file.
    """

    name: str
    file: str
    old: str | None
    new: str | bytes
    faults: tuple[tuple[str, int, int | str], ...]
    hint: str = ""


BILLION_LAUGHS = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n"
    for old, new in zip("abcdefg", "bcdefgh", strict=True)
)

BAD = [
    # the file as YAML
    Bad("larger than a pack", PARENT, None, b"#" * (MAX_PACK_BYTES + 1), (("P002", 1, 1),)),
    Bad("latin 1", PARENT, "title: Parent", b"title: caf\xe9", (("P003", 5, 11),), "UTF-8"),
    Bad("utf 16", PARENT, None, "kind: language".encode("utf-16"), (("P003", 1, 1),), "UTF-8"),
    Bad("byte order mark", PARENT, None, b"\xef\xbb\xbfkind: language", (("P004", 1, 1),), "BOM"),
    Bad("nul", PARENT, "title: Parent", "title: Pa\0rent", (("P005", 5, 10),)),
    Bad("escaped control", PARENT, "title: Parent", 'title: "a\\u0007"', (("P005", 5, '"a'),)),
    Bad("half a surrogate", PARENT, "title: Parent", 'title: "a\\uD800"', (("P008", 5, 'D800"'),)),
    Bad("empty", PARENT, None, "", (("P006", 1, 1),), "kind"),
    Bad("only blanks", PARENT, None, "\n  \n", (("P006", 1, 1),)),
    Bad("only a comment", PARENT, None, "# later\n", (("P006", 1, "# later"),)),
    Bad("tab", POSESET, "  FV: {}", "\tFV: {}", (("P007", 8, 1),), "spaces"),
    Bad("open bracket", PARENT, "adds: [yu]", "adds: [yu", (("P008", 6, "[yu"),), "at its end"),
    Bad("colon in text", PARENT, "title: Parent", "title: Parent: one", (("P008", 5, ": one"),)),
    Bad("two documents", CHILD, "words:", "---\nwords:", (("P009", 10, "---"),), "---"),
    Bad("deep", PARENT, "[yu]", "[" * 100_000, (("P010", 6, "["),), "bracket"),
    Bad("billion laughs", PARENT, None, BILLION_LAUGHS, (("P012", 2, "*a, *a,"),)),
    Bad("no anchor", PARENT, "title: Parent", "title: *x", (("P012", 5, "*x"),), "&x"),
    Bad("own anchor", PARENT, "adds: [yu]", "adds: &x [yu, *x]", (("P012", 6, "*x]"),)),
    Bad("merge key", CHILD, "  own: {x: yu}", "  own: {<<: {x: yu}}", (("P013", 9, "<<: {x:"),)),
    Bad("python tag", CHILD, "extends: parent", "extends: !!python/name:os.system parent",
        (("P014", 5, "!!pytho"),)),
    Bad("own tag", CHILD, "{x: yu}", "!foo {x: yu}", (("P014", 9, "!foo {x"),),
        "write the label in quotes"),
    Bad("duplicates go on", CHILD, "words:", "tag: qab\nname: child\nwords:",
        (("P015", 10, "tag: qa"), ("P015", 11, "name: c")), "line 4"),
    Bad("duplicate and unknown", CHILD, "words:", "tag: qab\nwrds: {}\nwords:",
        (("P015", 10, "tag: qa"), ("P101", 11, "wrds: {"))),
    Bad("key in brackets", CHILD, "{x: yu}", "{[x]: yu}", (("P016", 9, "[x]: yu"),)),
    Bad("yaml 1.1", CHILD, "kind: language", "%YAML 1.1\n---\nkind: language",
        (("P017", 1, "%YAML"),)),
    # the form of one pack
    Bad("unknown field", POSESET, "motion:", "moton:", (("P101", 19, "moton:"),), "'motion'"),
    Bad("unknown inner field", POSESET, "region: jaw", "regin: jaw",
        (("P101", 6, "regin:"),), "'region'"),
    Bad("two faults", POSESET, "threshold: 0.5", "threshhold: 3",
        (("P102", 13, "{betwee"), ("P101", 13, "threshh")), "threshold"),
    Bad("missing name", CHILD, "name: child\n", "", (("P102", 1, "kind: l"),)),
    Bad("missing kind", CHILD, "kind: language\n", "", (("P102", 1, "format:"),)),
    Bad("a list", CHILD, None, "- a\n", (("P103", 1, "- a"),), "kind"),
    Bad("text for a number", POSESET, "threshold: 0.5", "threshold: abc", (("P103", 13, "abc}"),)),
    Bad("decimal comma", POSESET, "window: 0.13", "window: '0,13'",
        (("P103", 19, "'0,13',"),), "point"),
    Bad("true for text", PARENT, "title: Parent", "title: true", (("P103", 5, "true"),), "quotes"),
    Bad("true for a number", POSESET, "open: 1,", "open: true,", (("P103", 24, "true, P"),)),
    Bad("union form once", PARENT, "Y: yu", "Y: 3", (("P103", 12, '3, 2: a, "~"'),)),
    Bad("a number in a list of labels", PARENT, "[f, a]}", "[f, 1]}", (("P103", 12, "1]}"),)),
    Bad("a number among names", PARENT, "adds: [yu]", "adds: [yu, 3]", (("P103", 6, "3]"),)),
    Bad("target of text", POSESET, "f: {FV: 0.9}", "f: [{FV: 0.9}, much]",
        (("P103", 22, "much]"),)),
    Bad("silence in a contact", POSESET, "phonemes: [f]", "phonemes: [f, _]",
        (("P106", 18, "_]"),), "silence has no contact"),
    Bad("dominance below 0", POSESET, "dominance: {PBM: 6, open: 6}", "dominance: -1",
        (("P104", 21, "-1}"),)),
    Bad("above 1", POSESET, "FV: 0.9}", "FV: 1.4}", (("P104", 22, "1.4}"),)),
    Bad("below 0", BANK, "[0.2, 1]", "[-0.2, 1]", (("P104", 7, "-0.2, 1"),)),
    Bad("no speed", POSESET, "speed_limit: 15", "speed_limit: 0", (("P104", 19, "0}"),)),
    Bad("infinite", POSESET, "open: 1,", "open: .inf,", (("P105", 24, ".inf, P"),)),
    Bad("not a number", BANK, "boundary: 0.4", "boundary: .nan", (("P105", 7, ".nan, c"),)),
    Bad("too long a number", POSESET, "open: 1,", f"open: {'9' * 5000},",
        (("P105", 24, "9999999"),)),
    Bad("name with a slash", CHILD, "name: child", "name: ../child",
        (("P106", 3, "../chil"), ("P111", 3, "../chil"))),
    Bad("label in capitals", COMMON, "yu: {title", "YU: {title", (("P106", 11, "YU: {ti"),)),
    Bad("tag with a space", CHILD, "tag: qaa-XX", "tag: qaa XX",
        (("P106", 4, "qaa XX"),), "BCP 47"),
    Bad("one phoneme", BANK, "p-yu:", "p:", (("P106", 8, "p:"),)),
    Bad("line break in a pose", POSESET, "  FV: {}", '  "F\\nV": {}', (("P106", 8, '"F'),)),
    Bad("unknown engine", PARENT, "engine: rules", "engine: rule",
        (("P107", 7, "rule, r"),), "'rules'"),
    Bad("unknown class", PARENT, "{vowel: 0.1", "{vowl: 0.1", (("P107", 9, "vowl: 0"),), "'vowel'"),
    Bad("format as text", CHILD, "format: 1", "format: '1'", (("P107", 2, "'1'"),)),
    Bad("one point", BANK, "[[0.2, 0], [1, 0]]", "[[0.2, 0]]", (("P108", 7, "[[0.2,"),)),
    Bad("three numbers", BANK, "[0.2, 1]", "[0.2, 1, 1]", (("P108", 7, "[0.2, 1"),)),
    Bad("one pose in a pair", POSESET, "[open, PBM]", "[open]", (("P108", 13, "[open],"),)),
    Bad("unknown kind", CHILD, "kind: language", "kind: langage",
        (("P109", 1, "langage"),), "'language'"),
    Bad("kind elsewhere", BANK, "kind: bank", "kind: rig", (("P109", 1, "rig"),), "folder"),
    Bad("newer", CHILD, "format: 1", "format: 2\nnew: {}", (("P110", 2, "2"),), "newer version"),
    Bad("other name", CHILD, "name: child", "name: kid", (("P111", 3, "kid"),), "rename"),
    Bad("name of a pose set", POSESET, "name: face", "name: visage", (("P111", 3, "visage"),)),
    Bad("three parts", BANK, "p-yu:", "p-yu-f:", (("P112", 8, "p-yu-f:"),), "`trigrams`"),
    Bad("four parts", BANK, "p-yu:", "p-yu-f-a:", (("P112", 8, "p-yu-f-"),)),
    Bad("two parts of a trigram", BANK, "bigrams:", "trigrams: {p-f: {curves: {}}}\nbigrams:",
        (("P106", 6, "p-f: {c"),), "three common phonemes"),
    Bad("silence within", BANK, "bigrams:", "trigrams: {p-_-f: {curves: {}}}\nbigrams:",
        (("P106", 6, "p-_-f: "),), "can only begin or end"),
    Bad("boundaries fall", BANK, "bigrams:",
        "trigrams: {p-a-f: {boundaries: [0.6, 0.5], curves: {}}}\nbigrams:",
        (("P104", 6, "[0.6, 0"),), "larger than the first"),
    Bad("a boundary at the end", BANK, "bigrams:",
        "trigrams: {p-a-f: {boundaries: [0.6, 1], curves: {}}}\nbigrams:",
        (("P104", 6, "1], cur"),)),
    Bad("one boundary", BANK, "bigrams:",
        "trigrams: {p-a-f: {boundaries: [0.6], curves: {}}}\nbigrams:", (("P108", 6, "[0.6],"),)),
    Bad("trigrams of a style", BANK, "bigrams:",
        "style: sad\ntrigrams: {p-a-f: {curves: {}}}\nbigrams:",
        (("P115", 7, "{p-a-f:"),), "bigrams"),
    Bad("phoneme in a trigram", BANK, "bigrams:", "trigrams: {p-q-f: {curves: {}}}\nbigrams:",
        (("P202", 6, "p-q-f: "),)),
    Bad("pose in a trigram", BANK, "bigrams:",
        "trigrams: {p-a-f: {curves: {VF: [[0, 0], [1, 0]]}}}\nbigrams:", (("P201", 6, "VF: [[0"),)),
    Bad("pose in an own trigram", ANNA, "bigrams:",
        "trigrams: {p-a-f: {curves: {VF: [[0, 0], [1, 0]]}}}\nbigrams:", (("P201", 5, "VF: [[0"),)),
    Bad("times fall", BANK, "[0.6, 0]", "[0.1, 0]", (("P113", 7, "[0.1, 0"),)),
    Bad("shares short", PARENT, "[0.4, 0.6]", "[0.4, 0.5]", (("P114", 14, "[0.4, 0"),)),
    Bad("a share too many", PARENT, "[0.4, 0.6]", "[0.4, 0.3, 0.3]", (("P114", 14, "[0.4, 0"),)),
    Bad("range reversed", RIG, "[0, 1]", "[1, 0]", (("P115", 6, "[1, 0]}"),)),
    Bad("axis without direction", RIG, "[1, 0, 0]", "[0, 0, 0]", (("P104", 8, "[0, 0, 0]"),)),
    Bad("bone without node", RIG, "node: Jaw, ", "", (("P115", 8, "[1, 0,"),)),
    Bad("node without turn", RIG, "rotation: [1, 0, 0], ", "", (("P115", 8, "Jaw, ga"),)),
    Bad("spellings of other numbers", COMMON, "base: [",
        'text: {alike: [["# m", "#-# m"], [B, "{b}"], [no., "№"]]}\nbase: [',
        (("P119", 12, '"#-# m'), ("P119", 12, '"{b}"')), ""),
    Bad("spelling in two lists", COMMON, "base: [",
        'text: {alike: [["# m", "# м"], ["#m", "# m"]]}\nbase: [', (("P119", 12, '["#m"'),)),
    Bad("spelling of other words", PARENT, "title: Parent",
        'title: Parent\ntext: {abbreviations: {"# m | # м": "{1} m", "#m | # m": "{1} mm"}}',
        (("P119", 6, '"{1} mm"'),), "leave it out"),
    Bad("no regular expression", PARENT, '"[ao]"', '"[ao"', (("P117", 7, '"[ao"'),)),
    Bad("no regular expressions", PARENT, "title: Parent",
        'title: Parent\ntext: {repeated: {x: "(a"}, rank_cases: {of: {before: "(b", after: "(c"}}}',
        (("P117", 6, '"(a"'), ("P117", 6, '"(b"'), ("P117", 6, '"(c"'))),
    Bad("no regular expressions of the engine", PARENT, "rules: [",
        'native: "(a", corrections: [{from: m, to: m, before: "(b", after: "(c", spelled: "(d", '
        'next_word: "(e"}], rules: [',
        tuple(("P117", 7, f'"({sign}"') for sign in "abcde")),
    Bad("a slow expression", PARENT, '"[ao]"', '"(a+)+"', (("P118", 7, '"(a+)+"'),), "atomic"),
    Bad("no such voice", PARENT, "voice: eo", "voice: isl", (("P226", 8, "isl}"),), "did you mean"),
    Bad("empty text", PARENT, "from: m", "from: ''", (("P116", 7, "'', to:"),)),
    # across places and files
    Bad("pose in a pair", POSESET, "between: [open, PBM]", "between: [open, PMB]",
        (("P201", 13, "PMB], t"),), "'PBM'"),
    Bad("pose in at_most", POSESET, "at_most: open", "at_most: opn", (("P201", 14, "opn}"),)),
    Bad("pose in priority", POSESET, "[open, FV, PBM]", "[open, FV, PMB]", (("P201", 15, "PMB]"),)),
    Bad("pose in a floor", POSESET, "floor: {FV", "floor: {VF", (("P201", 18, "VF: 0.8"),)),
    Bad("pose in a target", POSESET, "a: [{open", "a: [{opn", (("P201", 23, "opn: 0."),)),
    Bad("pose in dominance", POSESET, "PBM: 6", "PMB: 6", (("P201", 21, "PMB: 6,"),)),
    Bad("pose in a measure", POSESET, "{open: 1,", "{opn: 1,", (("P201", 24, "opn: 1,"),)),
    Bad("pose in a bank", BANK, "{FV: [[0", "{VF: [[0", (("P201", 7, "VF: [[0"),), "known: FV"),
    Bad("pose in a rig", RIG, "{PBM: 0.6}", "{PMB: 0.6}", (("P201", 7, "PMB: 0."),)),
    Bad("pose in a word", ANNA, "moi: {curves: {open", "moi: {curves: {opn",
        (("P201", 7, "opn: [["),)),
    Bad("pose in a line", ANNA, "1, curves: {open", "1, curves: {opn", (("P201", 8, "opn: [["),)),
    Bad("pose in an own bigram", ANNA, "f-a: {curves: {}", "f-a: {curves: {x: [[0, 0], [1, 0]]}",
        (("P201", 5, "x: [[0,"),)),
    Bad("shade of nothing", COMMON, "base: [", "shades: {x: {like: q, reason: r}}\nbase: [",
        (("P202", 12, "q, reason"),)),
    Bad("shade of a shade", COMMON, "base: [",
        "shades: {x: {like: a, reason: r}, z: {like: x, reason: r}}\nbase: [",
        (("P227", 12, "x, reason"),), "such as 'a'"),
    Bad("shade with the name of a phoneme", COMMON, "base: [",
        "shades: {f: {like: a, reason: r}}\nbase: [", (("P215", 12, "f: {like"),)),
    Bad("shade without a reason", COMMON, "base: [", "shades: {x: {like: a}}\nbase: [",
        (("P102", 12, "{like"),)),
    Bad("target of an unknown shade", POSESET, "  f: {FV: 0.9}", "  f: {FV: 0.9}\n  ae: {open: 1}",
        (("P202", 23, "ae: "),)),
    Bad("phoneme in base", COMMON, "[p, f, a]", "[p, f, a, q]", (("P202", 12, "q]"),)),
    Bad("phoneme it is like", COMMON, "like: a", "like: yu", (("P202", 11, "yu, cla"),)),
    Bad("phoneme of a label", PARENT, "P: p,", "P: q,", (("P202", 12, "q, Y: y"),)),
    Bad("phoneme in a list", PARENT, "no: [f, a]", "no: [f, q]", (("P202", 12, "q]}"),)),
    Bad("phoneme in shares", PARENT, "to: [p, f]", "to: [p, q]", (("P202", 14, "q], sha"),)),
    Bad("phoneme in a word", PARENT, "moi: [p, a]", "moi: [p, q]", (("P202", 15, "q]}"),)),
    Bad("phoneme in a test", PARENT, "phonemes: [p, a]", "phonemes: [p, q]",
        (("P202", 19, "q], sou"),)),
    Bad("phoneme that is read", PARENT, "phonemes: [p, a]", "phonemes: [p, a], read: [p, q]",
        (("P202", 19, "q], sou"),)),
    Bad("phoneme in a contact", POSESET, "phonemes: [p]", "phonemes: [q]",
        (("P202", 17, "q], flo"),)),
    Bad("phoneme with a target", POSESET, "  f: {FV", "  q: {FV", (("P202", 22, "q: {FV:"),)),
    Bad("phoneme in a bank", BANK, "  p-yu:", "  p-q:", (("P202", 8, "p-q:"),)),
    Bad("added but unknown", CHILD, "words:", "adds: {zz: null}\nwords:",
        (("P202", 10, "zz: nul"),)),
    Bad("no usual mapping", CHILD, "  own: {x: yu}", "  own: {x: yu, z}\n  ipa: {tʃx}",
        (("P238", 9, "z}"), ("P238", 10, "tʃx}")), "common phonemes"),
    Bad("of another language", BANK, "language: null", "language: child\nstyle: angry", ()),
    Bad("pose set unknown", ANNA, "poseset: face", "poseset: fce", (("P203", 4, "fce"),), "'face'"),
    Bad("bank of another", BANK, "poseset: face", "poseset: crab", (("P204", 4, "crab"),), "move"),
    Bad("rig of another", RIG, "poseset: face", "poseset: crab", (("P204", 4, "crab"),)),
    Bad("twice in priority", POSESET, "[open, FV, PBM]", "[open, FV, PBM, FV]",
        (("P205", 15, "FV]"),)),
    Bad("added twice", PARENT, "adds: [yu]", "adds: [yu, yu]", (("P205", 6, "yu]"),)),
    Bad("circle of at_most", POSESET, "- {pose: wide, at_most: open}",
        "- {pose: wide, at_most: open}\n    - {pose: open, at_most: wide}",
        (("P206", 14, "{pose:"), ("P206", 15, "{pose:")), "remove one"),
    Bad("no circle with a threshold", POSESET, "{pose: wide, at_most: open}",
        "{pose: wide, at_most: open}\n    - {between: [open, wide], threshold: 0.5}", ()),
    Bad("circle of channels", RIG, "{open: 0.7},", "{open: 0.7}, at_most: lips,",
        (("P206", 6, "lips, r"), ("P206", 7, "jawOpen"))),
    Bad("contact yields", POSESET, "[open, FV, PBM]", "[PBM, open, FV]", (("P207", 17, "PBM: 0."),),
        "after 'open'"),
    Bad("contact below another", POSESET, "{pose: wide, at_most", "{pose: PBM, at_most",
        (("P207", 17, "PBM: 0."),), "hold 'open'"),
    Bad("contacts of different phonemes exclude each other", POSESET, "{pose: wide, at_most: open}",
        "{between: [FV, PBM], threshold: 1}", (("W316", 17, "lips"),), "after 'teeth'"),
    Bad("one phoneme demands floors that exclude each other", POSESET,
        "{pose: wide, at_most: open}\npriority: [open, FV, PBM]\ncontacts:\n  lips: {phonemes: [p]",
        "{between: [FV, PBM], threshold: 1}\npriority: [open, FV, PBM]\n"
        "contacts:\n  lips: {phonemes: [p, f]",
        (("P208", 14, "1}"), ("W314", 22, "f: {")), "raise"),
    Bad("contacts just fit, rounding aside", POSESET, "{pose: wide, at_most: open}",
        "{between: [FV, PBM], threshold: 1.7}", ()),
    Bad("contacts exclude each other by default", POSESET, "default: 2.0", "default: 1.0",
        (("W316", 17, "lips"),)),
    Bad("contact outranked with room for its floor", POSESET,
        "0.5}\n    - {pose: wide, at_most: open}\npriority: [open, FV, PBM]",
        "0.9}\n    - {pose: wide, at_most: open}\npriority: [PBM, open, FV]", ()),
    Bad("ceiling on the pose of other phonemes", POSESET, "floor: {FV: 0.8}",
        "floor: {FV: 0.8}, ceiling: {PBM: 0}", ()),
    Bad("ceiling on a contact of one phoneme", POSESET, "[f], floor: {FV: 0.8}",
        "[f, p], floor: {FV: 0.8}, ceiling: {PBM: 0}",
        (("P209", 18, "PBM: 0}"), ("W314", 21, "p: {"), ("W314", 21, "p: {")), "both have p"),
    Bad("parent unknown", CHILD, "extends: parent", "extends: parnt",
        (("P210", 5, "parnt"),), "'parent'"),
    Bad("bank's language", BANK, "language: null", "language: chld",
        (("P210", 5, "chld"),), "'child'"),
    Bad("extends itself", CHILD, "extends: parent", "extends: child", (("P210", 5, "child"),)),
    Bad("rig unknown", ANNA, "rig: model", "rig: modl", (("P212", 10, "modl"),), "'model'"),
    Bad("bank missing", ANNA, "[anna-bank.yaml]", "[anna-bank.yaml, x.yaml]",
        (("P213", 6, "x.yaml]"),)),
    Bad("lexicon missing", PARENT, "engine: rules,", "engine: lexicon, file: x.txt,",
        (("P213", 7, "x.txt,"),)),
    Bad("channel unknown", RIG, "at_most: jawOpen", "at_most: jawopen", (("P214", 7, "jawopen"),)),
    Bad("named channel unknown", RIG, "names: {jawOpen", "names: {jawopen",
        (("P214", 9, "jawopen"),)),
    Bad("declared again", CHILD, "words:", "adds: {yu: {class: vowel}}\nwords:",
        (("P215", 10, "yu: {cl"),)),
    Bad("channel of braces unknown", RIG, "lips: {gains: {PBM: 0.6}, at_most: jawOpen",
        "lips{L,R}: {gains: {PBM: 0.6}, at_most: 'jaw{Open,X}'", (("P214", 7, "'jaw{Op"),)),
    Bad("channels of braces not as many", RIG, "lips: {gains: {PBM: 0.6}, at_most: jawOpen",
        "lips{L,R}: {gains: {PBM: 0.6}, at_most: 'jaw{A,B,C}'", (("P214", 7, "'jaw{A,"),)),
    Bad("channel twice", RIG, "  jaw: {node", "  jaw{Open,Left}: {gains: {}}\n  jaw: {node",
        (("P205", 8, "jaw{Ope"),), "'jawOpen' stands for it"),
    Bad("spelled twice", RIG, "JAW_OPEN]}", "JAW_OPEN], '{lips,jawOpen}': [x]}",
        (("P205", 9, "'{lips,"),)),
    Bad("spellings of braces not as many", RIG, "names: {jawOpen: [Jaw_Open, JAW_OPEN]}",
        "names: {'{jawOpen,lips}': ['{a,b}', '{a,b,c}']}", (("P115", 9, "'{a,b,c"),)),
    Bad("circle of braces", RIG, "lips: {gains: {PBM: 0.6}, at_most: jawOpen}",
        "lip{A,B}: {gains: {PBM: 0.6}, at_most: 'li{pB,p}'}\n  lip: {gains: {}, at_most: lipB}",
        (("P206", 7, "'li{pB,"), ("P206", 8, "lipB}"))),
    Bad("pose set that a rig drives", RIG, "poseset: face", "poseset: face\nto: fac",
        (("P203", 5, "fac"),), "'face'"),
    Bad("pose that a rig drives", RIG, "poseset: face", "poseset: face\nto: face",
        (("P201", 7, "jawOpen"), ("P201", 8, "lips:"))),
    Bad("pose that a rig loses", RIG, "lost: {FV", "lost: {VF", (("P201", 10, "VF: no "),)),
    Bad("model of a pose set", POSESET, "title: Face", "title: Face\nmodel: x.glb",
        (("P213", 5, "x.glb"),), "face/"),
    Bad("model of a character", ANNA, "rig: model", "rig: model\nmodel: x.glb",
        (("P213", 11, "x.glb"),), "characters/: copy it there"),
    Bad("pair twice", POSESET, "{pose: wide, at_most: open}",
        "{between: [PBM, open], threshold: 0.6}", (("P216", 14, "{betwee"),), "line 13"),
    Bad("pair of one", POSESET, "[open, PBM], thr", "[open, open], thr",
        (("P216", 13, "{betwee"),)),
    Bad("notation unknown", PARENT, "engine: rules,", "engine: rules, notation: irst,",
        (("P217", 7, "irst, r"),), "'first'"),
    Bad("rule of no label", PARENT, "to: P}", "to: Q}", (("P218", 7, "Q}"),), "known: "),
    Bad("unknown rules of numbers", PARENT, "title: Parent",
        'title: Parent\ntext: {number_rules: {counted: {1: one, 10: "ten[ >{joind}]"}}}',
        (("P236", 6, '"ten'),), "counted"),
    Bad("unit of two words", PARENT, "title: Parent",
        'title: Parent\ntext: {lists: {unit: {m: metres, "m | km": kilometres}, month: [may, 6]}}',
        (("P119", 6, "kilomet"), ("P103", 6, "6]")), ""),
    Bad("rules like unknown ones, with an ending that no word has", PARENT, "title: Parent",
        "title: Parent\ntext: {number_rules: {one: {1: primo}, two: {like: on, endings: {o: a}}, "
        "three: {like: one, endings: {o: a, i: e}}}}",
        (("P236", 6, "on, "), ("W308", 6, "i: e}")), ""),
    Bad("rules like each other, and like such", PARENT, "title: Parent",
        "title: Parent\ntext: {number_rules: {a: {like: b, endings: {o: a}}, "
        "b: {like: a, endings: {o: a}}, c: {like: c, endings: {o: a}}, full: {1: primo}}}",
        (("P236", 6, "b, "), ("P236", 6, "a, endings: {o: a}}, c"), ("P236", 6, "c, ")), "full"),
    Bad("rules without endings", PARENT, "title: Parent",
        "title: Parent\ntext: {number_rules: {one: {1: primo}, two: {like: one, ends: {o: a}}, "
        "three: {like: one, endings: {}}}}",
        (("P102", 6, "{like: one, e"), ("P101", 6, "ends"), ("P108", 6, "{}")), ""),
    Bad("unknown list of words", PARENT, "title: Parent",
        'title: Parent\ntext: {lists: {month: [may]}, abbreviations: {"# {moth}": "{1} {moth}"}}',
        (("P236", 6, '"# {mo'),), "month"),
    Bad("place that the spelling lacks", PARENT, "title: Parent",
        'title: Parent\ntext: {abbreviations: {"# km": "{2} kilometres"}}',
        (("P236", 6, '"{2}'),), "1"),
    Bad("place that one of two spellings lacks", PARENT, "title: Parent",
        'title: Parent\ntext: {abbreviations: {"#-# | #–# m": "{1} {2}", "№ # | No.": "{1}"}}',
        (("P236", 6, '"{1}"}'),), ""),
    Bad("unknown list of numbers", PARENT, "title: Parent",
        'title: Parent\ntext: {numbers: {ordinal: [first]}, abbreviations: {"#.": "{1:ordinals}"}}',
        (("P236", 6, '"{1:'),), "ordinal"),
    Bad("correction to no label", PARENT, "engine: rules,",
        "engine: rules, corrections: [{from: x, to: Q}],", (("P218", 7, "Q}]"),), "known: "),
    Bad("correction of timings", PARENT, "engine: rules,",
        "engine: rules, corrections: [{from: ts, to: [ts, ts], timings: true}],",
        (("P115", 7, "true"),), ""),
    Bad("one label twice", PARENT, "Y: yu,", "Y: yu, g: p, \u0261: f,",
        (("P219", 12, "\u0261: f"),), "one of the two"),
    Bad("phoneme unmapped", PARENT, "tests:",
        "inventory: {source: nobody, segments: [ts, x]}\ntests:", (("P220", 18, "x]}"),), "map it"),
    Bad("test against its source", PARENT, "phonemes: [p, a],", "phonemes: [p, a], ipa: ts,",
        (("P221", 19, "ts, sou"),), "correct"),
    Bad("source of no label", PARENT, "phonemes: [p, a],", "phonemes: [p, a], ipa: tz,",
        (("P218", 19, "tz, sou"),), "known: ts"),
    Bad("spelling of two poses", POSESET, "FV: {}",
        "FV: {names: ['{JAW,lip}Down', press*]}\n  PBM2: {names: [jawdown, OPEN]}",
        (("W301", 9, "PBM2"), ("P224", 9, "jawdown"), ("P224", 9, "OPEN]}")), "'FV' comes first"),
    Bad("rest is a pose", POSESET, "title: Face", "title: Face\nneutral: wide",
        (("P225", 5, "wide"),), "rename"),
    Bad("measure of a rule", POSESET, "PBM: -1}}",
        "PBM: -1}}\nchecks: {rules: {opens: {phonemes: [a], measure: apertur, at_least: 0.1}}}",
        (("P231", 25, "apertur"),), "'aperture'"),
    Bad("measure of a character's rule", ANNA, "rig: model",
        "rig: model\nchecks: {rules: {opens: {phonemes: [a], measure: gape, at_least: 0.1}}}",
        (("P231", 11, "gape"),), "known: aperture"),
    Bad("gestures that move speech, or nothing", POSESET, "title: Face",
        "title: Face\n"
        "gesture_poses: {wide: {region: lips, speed_limit: 9}, "
        "lid: {region: eyes, speed_limit: 9}}\n"
        "gestures:\n"
        "  blink: {on: pause, curve: [[0, 0], [0.5, 1], [1, 0]], "
        "poses: {lid: 1, open: 1, lids: 1}}",
        (("P232", 5, "wide"), ("P232", 7, "open: 1"), ("P201", 7, "lids")), "declared under"),
    Bad("gestures too fast and too large", POSESET, "title: Face",
        "title: Face\n"
        "gesture_poses: {lid: {region: eyes, speed_limit: 9}}\n"
        "gestures:\n"
        "  fast: {on: pause, curve: [[0, 0], [0.1, 1], [1, 0]], poses: {lid: 1}}\n"
        "  large: {on: pause, curve: [[0, 0], [0.5, 1], [1, 0]], poses: {lid: 1.5}}",
        (("P233", 7, "1}}"), ("P233", 8, "1.5}}")), "raise `most`"),
    Bad("mirrored poses that no name has", POSESET, "title: Face",
        "title: Face\nmirrored: {Links: Rechts}",
        (("P235", 5, "Links"),), "such as `Left: Right`"),
    Bad("gesture of a character", ANNA, "rig: model",
        "rig: model\ngestures: {blinc: 0.5}\n",
        (("P234", 11, "blinc"),)),
    Bad("gesture placed twice, or by nothing", POSESET, "title: Face",
        "title: Face\n"
        "gestures:\n"
        "  both: {on: pause, per_minute: {speech: 9, silence: 9}, curve: [[0, 0], [1, 1], [2, 0]], "
        "poses: {lid: 1}}\n"
        "  drawn: {on: pause, at: pause, curve: [[0, 0], [1, 1], [2, 0]], poses: {lid: 1}}\n"
        "  ends: {on: pause, curve: [[0, 0], [1, 1], [2, 0.5]], poses: {lid: 1}}\n"
        "  back: {on: pause, curve: [[0, 0], [1, 1], [1, 0]], poses: {lid: 1}}",
        (("P115", 6, "pause, per"), ("P115", 7, "pause, curve: [[0"), ("P113", 8, "[2"),
         ("P113", 9, "[1, 0]"))),
    Bad("gesture pose with half a turn", POSESET, "title: Face",
        "title: Face\n"
        "gesture_poses:\n"
        "  nod: {region: head, speed_limit: 9, node: Head}\n"
        "  lid: {region: eyes, speed_limit: 9, most: 3}\n"
        "  tilt: {region: head, speed_limit: 9, node: Head, rotation: [0, 0, 0]}",
        (("P115", 6, "Head"), ("P115", 7, "3}"), ("P104", 8, "[0, 0, 0]"))),
    Bad("phonemes of a rule", POSESET, "PBM: -1}}",
        "PBM: -1}}\nchecks: {rules: {x: {phonemes: [a, b, a], measure: aperture, at_most: 0}}}",
        (("P202", 25, "b, a"), ("P205", 25, "a], mea"))),
    Bad("rule that bounds nothing", POSESET, "PBM: -1}}",
        "PBM: -1}}\nchecks: {rules: {opens: {phonemes: [a], measure: aperture}}}",
        (("P115", 25, "aperture"),), ""),
    Bad("rule that nothing meets", POSESET, "PBM: -1}}",
        "PBM: -1}}\nchecks: {rules: {x: {phonemes: [a], measure: aperture,\n"
        "  at_least: 1, at_most: 0}}}",
        (("P115", 26, "1, at_m"),), ""),
    Bad("limit of no measure", POSESET, "PBM: -1}}", "PBM: -1}}\nchecks: {jiter: 2}",
        (("P101", 25, "jiter"),), "'jitter'"),
    Bad("limit past all", POSESET, "PBM: -1}}", "PBM: -1}}\nchecks: {still: 2}",
        (("P104", 25, "2}"),)),
    # warnings
    Bad("rule after a shorter one", PARENT, "{from: h,", "{from: mm, to: P}, {from: h,",
        (("W307", 7, "{from: mm"),), "line 7"),
    Bad("label twice, the same", PARENT, "Y: yu,", "Y: yu, g: p, \u0261: p,",
        (("W308", 12, "\u0261: p"),)),
    Bad("labels that no text has", PARENT, "first: {P: p,",
        "first: {P: p, \u0435: a, \u02c8e: a, \u0303e: a, e\u2060: a,",
        (("W308", 12, "\u0435: a"), ("W308", 12, "\u02c8e"), ("W308", 12, "\u0303e"),
         ("W308", 12, "e\u2060"))),
    Bad("label that is a comment", PARENT, "  ipa:\n", "  ipa:\n    #: p\n",
        (("W308", 14, "#: p"),), "`'#': ...`"),
    Bad("pattern in the letters of a rule", PARENT, "{from: m,", "{from: (?:m),",
        (("W308", 7, "(?:m)"),), "`before` and `after`"),
    Bad("ten letters in a tag", PARENT, "tag: qaa", "tag: qaaqaaqaaq", (("P106", 4, "qaaq"),)),
    Bad("pose with the name of a column", POSESET, "  FV: {}", "  FV: {}\n  time_s: {}",
        (("P106", 9, "time_s"),), "another name"),
    Bad("no-break space", PARENT, "title: Parent", "title:\u00a0Parent",
        (("P008", 5, "\u00a0Par"),), "ordinary space"),
    Bad("no-break space before a field", PARENT, "title: Parent", "\u00a0title: Parent",
        (("P005", 5, 1),), "ordinary space"),
    Bad("no-break space before a word", PARENT, "{moi: [p, a]}", "{\u00a0moi: [p, a]}",
        (("P005", 15, "\u00a0moi"),), "ordinary space"),
    Bad("no-break spaces in the margin", PARENT, "  first: {P", "\u00a0\u00a0first: {P",
        (("P005", 12, 1), ("P008", 12, 1)), "ordinary space"),
    Bad("format in quotes", PARENT, "format: 1", 'format: "1"', (("P107", 2, '"1"'),),
        "without quotes"),
    Bad("name without a value", PARENT, "name: parent", "name: null", (("P103", 3, "null"),),
        "write a value; text"),
    Bad("number for a list", PARENT, "{moi: [p, a]}", "{moi: 1}", (("P103", 15, "1}"),),
        "[one, two]"),
    Bad("example of no label", PARENT, "{P: moi}", "{Q: moi}", (("W308", 16, "Q: moi"),)),
    Bad("reason for no label", PARENT, "{Y: rounded}", "{X: rounded}", (("W308", 17, "X: roun"),)),
    Bad("absent from no inventory", PARENT, "tests:",
        "inventory: {source: nobody, segments: [ts], absent: {x: none}}\ntests:",
        (("W308", 18, "x: none"),)),
    Bad("absent but mapped", PARENT, "tests:",
        "inventory: {source: nobody, segments: [ts], absent: {ts: none}}\ntests:",
        (("W308", 18, "ts: none"),)),
    Bad("pose without target", POSESET, "wide: 0.1", "FV: 0.1", (("W301", 9, "wide:"),)),
    Bad("tie", POSESET, "{pose: wide, at_most: open}\npriority: [open, FV, PBM]",
        "{between: [wide, FV], threshold: 1}\npriority: [open, PBM]", (("W302", 14, "{betwee"),)),
    Bad("pose never shown", RIG, "lost: {FV: no lower lip, wide: no corners}",
        "lost: {wide: no corners}", (("W311", 5, "channel"),), "under `lost`"),
    Bad("pose shown by nothing", RIG, "{PBM: 0.6}", "{PBM: 0}", (("W311", 5, "channel"),)),
    Bad("contact that demands nothing", POSESET, "  teeth: {phonemes: [f], floor: {FV: 0.8}}",
        "  teeth: {phonemes: [f], floor: {FV: 0}, ceiling: {open: 1}}",
        (("W312", 18, "teeth:"),), "remove the contact"),
    Bad("threshold out of reach", POSESET, "{pose: wide, at_most: open}",
        "{between: [open, wide], threshold: 0.55}", (("W313", 14, "0.55}"),), "lower"),
    Bad("threshold that a bank's curve reaches", POSESET, "{pose: wide, at_most: open}",
        "{between: [open, FV], threshold: 1.4}", ()),
    Bad("target below a floor", POSESET, "f: {FV: 0.9}", "f: {FV: 0.7}", (("W314", 22, "f: {FV"),),
        "satisfies it"),
    Bad("target above a ceiling", POSESET, "p: {PBM: 1.0,", "p: {PBM: 1.0, open: 0.2,",
        (("W314", 21, "p: {PBM"),)),
    Bad("other suffix", "languages/extra.yml", None, CHILD, (("W303", 1, "languag"),), "rename"),
]  # fmt: skip


def faults_of(root: Path) -> list[Fault]:
    """Return every fault of the packs below a folder."""
    return validate(Library([root], project=None), [root])


def test_the_tree_is_sound(tmp_path):
    assert faults_of(plant(tmp_path)) == []


UNKNOWN = {
    "phonemes of a rule", "phoneme in a contact", "phoneme with a target",
    "target of an unknown shade",
    "phoneme in a bank",
}  # fmt: skip
"""Faults whose check reads all languages, in search of one that declares the phoneme."""


@pytest.mark.parametrize(
    "bad", [pytest.param(bad, marks=[full] * (bad.name in UNKNOWN), id=bad.name) for bad in BAD]
)
def test_a_bad_pack_gives_its_faults_at_their_places(bad, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plant(tmp_path)
    content = bad.new if isinstance(bad.new, bytes) else bad.new.encode()
    if bad.old is not None:
        whole = TREE[bad.file].encode()
        assert whole.count(bad.old.encode()) == 1, "the change must be plain"
        content = whole.replace(bad.old.encode(), content)
    put(tmp_path, bad.file, content)

    found = faults_of(tmp_path)

    here = [fault for fault in found if fault.file == str(Path(bad.file))]
    assert [(f.code, f.line) for f in here] == [(code, line) for code, line, _ in bad.faults]
    lines = content.decode("utf-8", "replace").split("\n")
    for fault, (_, _, place) in zip(here, bad.faults, strict=True):
        if isinstance(place, int):
            assert fault.column == place
        else:
            assert lines[fault.line - 1][fault.column - 1 :].startswith(place)
    if bad.hint:
        assert any(bad.hint in fault.hint for fault in here)


@full
def test_a_pose_set_may_speak_of_what_any_language_declares(tmp_path):
    plant(tmp_path)
    child = TREE["languages/child.yaml"].replace("words:", "adds: {zz: {class: vowel}}\nwords:")
    put(tmp_path, "languages/child.yaml", child)
    face = TREE["posesets/face/poseset.yaml"].replace(
        "  f: {FV: 0.9}", "  f: {FV: 0.9}\n  zz: {FV: 1}"
    )
    put(tmp_path, "posesets/face/poseset.yaml", face)
    assert faults_of(tmp_path) == []
    put(tmp_path, "posesets/face/poseset.yaml", face.replace("zz:", "zy:"))
    assert [fault.code for fault in faults_of(tmp_path)] == ["P202"]


PAIR = """\
kind: poseset
format: 1
name: pair
poses: {a: {}, b: {}, c: {}}
constraints:
  default: %s
  pairs: [{between: [a, c], threshold: 2}, {between: [b, c], threshold: 2}]
priority: %s
targets: {p: {a: 0.5, b: 0.25}, f: {a: 0.25, c: 1}}
"""


@pytest.mark.parametrize(
    ("default", "priority", "found"),
    [
        ("0.6", "[a, b]", []),
        ("0.6", "[b]", []),
        (
            "0.6",
            "[c]",
            ["6:12: W302 warning: none of 'a', 'b' yields: `priority` names none of them"],
        ),
        ("0.6", "[x]", ["8:12: P201 unknown pose 'x'"]),
        ("0.75", "[a]", ["6:12: W313 warning: 'a' and 'b' never add up to more than 0.75"]),
    ],
)
def test_a_default_threshold_binds_some_pair_and_one_of_it_yields(
    default, priority, found, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    plant(tmp_path)
    put(tmp_path, "posesets/pair/poseset.yaml", PAIR % (default, priority))
    prefix = str(Path("posesets/pair/poseset.yaml")) + ":"
    assert [str(f).removeprefix(prefix).split("\n")[0] for f in faults_of(tmp_path)] == found


def test_nobody_says_what_is_out_of_reach_of_an_unsound_bank(tmp_path):
    plant(tmp_path)
    put(tmp_path, "posesets/pair/poseset.yaml", PAIR % ("0.75", "[a]"))
    put(tmp_path, "posesets/pair/banks/common.yaml", "kind: bank\n")
    assert "W313" not in {fault.code for fault in faults_of(tmp_path)}


def test_a_trigram_may_bring_poses_up_to_a_threshold(tmp_path):
    plant(tmp_path)
    put(tmp_path, "posesets/pair/poseset.yaml", PAIR % ("0.75", "[a]"))
    head = "kind: bank\nformat: 1\nname: common\nposeset: pair\ntrigrams:\n  p-a-p:\n"
    for height, codes in (("0.1", {"W313"}), ("1", set())):
        curves = f"    curves: {{b: [[0, {height}], [1, {height}]]}}\n"
        put(tmp_path, "posesets/pair/banks/common.yaml", head + curves)
        assert {fault.code for fault in faults_of(tmp_path)} & {"W313"} == codes


def test_a_file_holds_a_thousand_trigrams_at_most(tmp_path):
    plant(tmp_path)
    names = ["".join(three) for three in product("abcdefghij", repeat=3)]
    whole = "".join(f"  p-{name}-f: {{curves: {{}}}}\n" for name in [*names, "p"])
    bank = TREE["posesets/face/banks/common.yaml"]
    put(tmp_path, "posesets/face/banks/common.yaml", f"{bank}trigrams:\n{whole}")
    (fault,) = (fault for fault in faults_of(tmp_path) if fault.code != "P202")
    assert (fault.code, fault.line) == ("P108", bank.count("\n") + 2)
    assert "`trigrams` must have at most 1000 items, got 1001" in fault.what


def test_every_code_is_met_by_a_bad_pack():
    met = {code for bad in BAD for code, _, _ in bad.faults}
    elsewhere = {
        "P001": "test_packs_library: a missing file",
        "P011": "test_packs_events: aliases that multiply",
        "P237": "test_phonemizer: bad lines of an orthography profile",
        "P222": "test_ipa: an unknown word or feature",
        "P223": "test_ipa: an unknown letter or mark",
        **dict.fromkeys(
            ("P401", "P402", "P403", "P404", "P405", "P406", "P407", "P408", "W315"),
            "test_planning_faults: projects that cannot be built",
        ),
        "P239": "test_checked_as_run: engines and models of recordings",
        "P409": "test_project_timings: a file that a format does not fit",
        "P211": "test_packs_library: a circle of languages",
        "W304": "test_packs_library: a broken distribution",
        "P230": "test_delivery: a style or region that is not there",
        "W320": "test_delivery: a style or region that is not there",
        "W305": "test_packs_library: two languages of one tag",
        "W321": "test_checked_as_run: a notation that is nearly inherited",
        "W323": "test_packs_library: a pack in place of a built-in one",
        "W322": "test_solving: mouths of a head that is not solved",
        "W309": "test_authoring: a sound that closes nothing",
        "W310": "test_authoring: a language that cannot be read",
        "W306": "test_resolver: an edited bigram that does not close",
    }
    assert met.isdisjoint(elsewhere)
    assert met | set(elsewhere) == set(fault_codes())


def test_a_fault_prints_where_what_and_how_to_mend_it():
    fault = Fault("a.yaml", 14, 22, "P201", "unknown pose 'opne'", "did you mean 'open'?")
    assert str(fault) == "a.yaml:14:22: P201 unknown pose 'opne'\n  hint: did you mean 'open'?"
    assert str(Fault("a", 1, 2, "P201", "x")) == "a:1:2: P201 x"
    assert json.loads(json.dumps(fault.to_dict()))["line"] == 14


def test_faults_sort_by_place():
    faults = [Fault(f, line, 1, "P201", "x") for f in "ba" for line in (10, 9)]
    assert [(f.file, f.line) for f in sorted(faults)] == [("a", 9), ("a", 10), ("b", 9), ("b", 10)]


def test_a_code_nobody_can_look_up_is_refused():
    with pytest.raises(ValueError, match="P999"):
        Fault("a.yaml", 1, 1, "P999", "x")


def test_pack_faults_print_all_of_them():
    error = PackFaults([Fault("a", 1, 1, "P201", "x"), Fault("a", 2, 1, "P202", "y")])
    assert str(error) == "a:1:1: P201 x\na:2:1: P202 y"
    assert isinstance(error, LipsyncError)


@pytest.mark.parametrize(
    ("file", "slips", "codes"),
    [
        (POSESET, {"open: 0.45, wide": "open: 0.45, wdie", "PBM: 0.9": "PBM: 1.9"}, "P104 P201"),
        (PARENT, {"P: p,": "P: q,", "vowel: 0.1,": "vowel: -1,"}, "P104 P202"),
        (
            POSESET,
            {"threshold: 0.5": "threshold: 5", "at_most: open": "at_most: 1", "FV: 0.9}": "VF: 1}"},
            "P103 P104 P201",
        ),
        (BANK, {"[0.2, 1]": "[0.2, 2]", "poseset: face": "poseset: fase"}, "P104 P204"),
    ],
)
def test_faults_of_form_do_not_hide_faults_of_sense(file, slips, codes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plant(tmp_path)
    text = TREE[file]
    for old, new in slips.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    put(tmp_path, file, text)
    assert sorted(f.code for f in faults_of(tmp_path) if f.file == file) == codes.split()


def test_a_misspelt_pose_in_the_priority_is_one_fault(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plant(tmp_path)
    put(tmp_path, POSESET, TREE[POSESET].replace("priority: [open,", "priority: [opne,"))
    assert [fault.code for fault in faults_of(tmp_path)] == ["P201"]


@pytest.mark.parametrize("code", sorted(fault_codes()))
def test_every_code_has_a_meaning_a_cause_and_a_cure(code):
    told = fault_codes()[code]
    for sentence in (told.meaning, told.cause, told.cure):
        assert re.fullmatch(r"[A-Z`].{8,}\.", sentence)


def test_patterns_with_a_cure_of_their_own_are_those_of_the_models():
    schemas = json.dumps([model.model_json_schema() for model in MODELS.values()])
    fields = r'"pattern(?:Properties)?": {?("(?:[^"\\]|\\.)*")'
    stated = set(map(json.loads, re.findall(fields, schemas)))
    others = {TAG_PATTERN, ALIAS_PATTERN, "#", r"^(?:\w+ )?~\.?$"}
    assert set(_words()["patterns"]) == stated - others
