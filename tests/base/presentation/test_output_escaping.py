"""Unusual names in every format: no name breaks the file that contains it."""

import csv
import json
import re
from dataclasses import replace
from html import unescape
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from file_bytes import bytes_of
from glb_files import document_of, mesh, model_of, parts
from lanes import needs_plug_ins, of_plug_in
from take_files import take_names
from test_coverage_page import Reader
from test_line_page import data_of

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.reports.coverage.changes import ScriptChange
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.report import (
    AuthoredShare,
    BigramNeed,
    Corpus,
    Coverage,
    CoverageChanges,
    CoverageReport,
    NextHour,
    ReportChange,
    Tally,
    WorkLeft,
)
from lipsync_lang.reports.coverage.total import total_of
from lipsync_lang.schedules.timing_readers import TIMING_READERS

DRAWN = of_plug_in("test_drawn_mouth_files", "READERS")
READERS = of_plug_in("test_engine_files", "READERS")

ODD = (
    'a "quoted" one',
    "it's",
    "]]>",
    "<b>&amp;</b>",
    "<!-- -->",
    "one, two; three",
    "back\\slash\\n",
    "two\nlines",
    "tab\tand\rreturn",
    "{x} %s $y #z",
    "00:00 --> 01:00",
    "=1+1",
    '"""',
    "'''",
    "- yes: no",
    "Mündchen 口 \U0001f600",
    "nul \x00 and bell \x07",
)
"""Characters that the name of a shape, a word or a file may have."""

NO_NAMES = {
    "audacity": "labels of phonemes alone",
    "mp4": "a video",
    "png": "pictures",
    "wav": "a sound",
    "webm": "a video",
}
"""Formats without names of the animation."""

OWN_SHAPES = {
    "azure": "arkit",
    "live-link-face": "arkit",
    "rhubarb-json": "rhubarb",
    "rhubarb-tsv": "rhubarb",
    "rhubarb-xml": "rhubarb",
}
"""Formats with their own names of shapes, and the pose set with these; other names are odd."""

SPOKEN = ll.Schedule(
    ("P",) * len(ODD),
    np.arange(len(ODD) + 1) / 10,
    words=tuple(ll.Word(text, n, n + 1) for n, text in enumerate(ODD)),
    notation="arpabet",
    source=" ".join(ODD),
)

odd_writers = pytest.mark.parametrize("name", sorted(set(WRITERS) - set(NO_NAMES)))


def odd(name, tmp_path):
    """Return an animation with unusual names wherever the format allows them."""
    if name in OWN_SHAPES:
        return ll.resolve("english", OWN_SHAPES[name]).perform(SPOKEN, fps=60)
    times = np.arange(len(ODD) * 6) / 60
    weights = np.repeat(np.eye(len(ODD)), 6, axis=0)
    animation = Animation(
        times, ODD, weights, 60, SPOKEN, neutral="at\nrest", contacts={ODD[0]: 0.5}
    )
    if name == "glb":
        model = tmp_path / "face.glb"
        model.write_bytes(model_of(document_of(mesh("]]>\n\"'", ODD))))
        animation = replace(animation, model=model)
    return animation


def table(content, animation):
    rows = list(csv.reader(StringIO(content.decode("utf-8"), newline=""), strict=True))
    assert {len(row) for row in rows} == {len(rows[0])}
    assert len(rows) == len(animation.times) + 1
    return rows[0][1:]


def document(content, animation):
    found = json.loads(content)
    assert [word["text"] for word in found["words"]] == list(ODD)
    assert len(found["frames"]) == len(animation.times)
    return found["poses"]


def model(content, _):
    return parts(content)[0]["meshes"][0]["extras"]["targetNames"]


def resource(content, animation):
    return [
        path.removeprefix(".:blend_shapes/")
        for path in of_plug_in("test_godot", "from_tres")(content, animation)
    ]


def drawings(name):
    return lambda content, animation: [shape for _, _, shape in DRAWN[name](content, animation)]


def curves(content, _):
    rows = list(csv.reader(StringIO(content.decode("utf-8"), newline=""), strict=True))
    assert {len(row) for row in rows} == {len(rows[0])}
    return [name for name, *_ in rows[1:]]


def cues(name):
    def names(content, _):
        read = of_plug_in("test_subtitle_files", "read")
        return [text for _, _, text in read(name, content.decode("utf-8"))]

    return names


def engine(name):
    return lambda content, animation: list(READERS[name][0](content, animation))


def page(content, _):
    take = data_of(content.decode("utf-8"))["takes"][0]
    assert [word for word, *_ in take["spoken"]["words"]] == list(ODD)
    return take["poses"]


TIMINGS = {"elan": "eaf", "textgrid": "TextGrid", "timings-csv": "csv", "timings-json": "json"}


def timings(suffix):
    """Return a reader of the words of timings, which have no names of poses."""

    def words(content, _):
        if not TIMING_READERS.ending(Path(f"line.{suffix}")):
            pytest.skip("the plug-in that reads it was removed")
        with TemporaryDirectory() as folder:
            path = Path(folder, f"line.{suffix}")
            path.write_bytes(content)
            return [word.text for word in ll.read_schedule(path).words]

    return words


NAMES = {
    **{name: timings(suffix) for name, suffix in TIMINGS.items()},
    **{name: engine(name) for name in READERS},
    **{name: drawings(name) for name in DRAWN},
    "csv": table,
    "glb": model,
    "godot": resource,
    "html": page,
    "json": document,
    "srt": cues("srt"),
    "unreal": curves,
    "usd": lambda content, animation: list(of_plug_in("test_usd", "from_usda")(content, animation)),
    "player": lambda content, _: take_names(content)[0],
    "vrma": lambda content, animation: list(
        of_plug_in("test_avatar_files", "from_vrma")(content, animation)
    ),
    "vtt": lambda content, animation: list(map(unescape, cues("vtt")(content, animation))),
}
"""Reader as strict as the programs for a file; it returns the names in the file."""

NAMES = {name: reader for name, reader in NAMES.items() if name in WRITERS}

ONE_LINE = [" ".join(name.split()) for name in ODD]

SINGLE = [name.replace("\x00", "\ufffd").replace("\x07", "\ufffd") for name in ONE_LINE]

CHANGED = {
    **{name: SINGLE for name in TIMINGS if name != "timings-json"},
    "godot": [name.replace(":", "_").replace("\\\\", "\\") for name in ODD],
    "maya": [
        "a__quoted__one",
        "it_s",
        "___",
        "_b__amp___b_",
        "________",
        "one__two__three",
        "back_slash_n",
        "two_lines",
        "tab_and_return",
        "_x___s__y__z",
        "_00_00_____01_00",
        "_1_1",
        "____2",
        "____3",
        "__yes__no",
        "M_ndchen____",
        "nul___and_bell__",
    ],
    "moho": ONE_LINE,
    "renpy": [re.sub(r'[\\/:*?"<>|\x00-\x1f]', "_", name) for name in ODD],
    "smartbody": ["".join(c if c.isprintable() else "\ufffd" for c in name) for name in ODD],
    "srt": [name.replace("-->", "→") for name in ONE_LINE],
    "vtt": ONE_LINE,
}
"""Formats that cannot contain some letters, and their replacements."""


def test_every_writer_is_swept():
    assert set(NAMES) | set(NO_NAMES) == set(WRITERS)


@odd_writers
def test_odd_names_stay_what_they_are_and_break_nothing(name, tmp_path):
    animation = odd(name, tmp_path)
    names = NAMES[name](bytes_of(name, animation), animation)
    assert names
    if name not in OWN_SHAPES:
        assert names == list(CHANGED.get(name, ODD))


@needs_plug_ins
def test_what_was_spoken_is_told_by_rhubarbs_files(tmp_path):
    told = json.loads(bytes_of("rhubarb-json", odd("rhubarb-json", tmp_path)))
    assert told["metadata"]["soundFile"] == SPOKEN.source
    root = ET.fromstring(bytes_of("rhubarb-xml", odd("rhubarb-xml", tmp_path)))  # noqa: S314 ours
    kept = SPOKEN.source.replace("\x00", "\ufffd").replace("\x07", "\ufffd")
    assert root.find("metadata/soundFile").text == kept.replace("\r", "\n")


# Coverage


def odd_report(name, other):
    """Return a report in which all is called oddly that a project or a script names."""
    need = BigramNeed(
        bigram="aa-d", count=1, percent=100, running=100, layer="language", status="drafted",
        example=name, places=(f"{name}:1",),
    )  # fmt: skip
    return CoverageReport(
        language=name, language_title=name, character=other, poseset=other, lines=1, words=1,
        phonemes={"aa": 1, "d": 1}, occurrences=1, bigrams=(need,), silence=(need,), unused=(),
        needed={"100": 1}, authored=AuthoredShare(bigrams=0, percent=0),
        left=WorkLeft(bigrams=1, hours=1), next_hour=NextHour(bigrams=("aa-d",), percent=100),
        sentences=(), column=name, unmapped=(),
        unread=(Tally(what=name, count=1, place=f"{name}:1"),),
    )  # fmt: skip


def odd_coverage():
    """Return a document of one report for each odd name, compared with an older one."""
    reports = tuple(map(odd_report, ODD, ODD[::-1]))
    script = ScriptChange(languages=ODD, lines=(1, 2), added=ODD, removed=ODD, changed=ODD)
    changes = tuple(
        ReportChange(
            language=one.language, character=one.character, percent=(0, 0), left=(1, 1),
            authored=(), lost=("d-d",), new=("aa-d",), gone=("d-aa",), column=one.column,
        )
        for one in reports
    )  # fmt: skip
    return Coverage(
        corpus=Corpus(files=ODD, lines=1, words=1),
        minutes=5,
        reports=reports,
        shared=(),
        total=total_of(reports, 5),
        since=CoverageChanges(file="".join(ODD), reports=changes, unmatched=ODD, script=(script,)),
    )


def covered(form):
    out = StringIO(newline="")
    FORMS.find(form)(odd_coverage(), out, FormOptions(everything=True))
    return out.getvalue()


def words_of(text):
    return " ".join(re.sub("[\x00-\x08\x0b\x0c\x0e-\x1f]", "\ufffd", text).split())


def test_the_total_and_the_changes_of_a_coverage_page_show_odd_names():
    root = Reader(covered("html")).root
    total, since = (words_of(root.one("section", id=name).text) for name in ("total", "since"))
    for name in map(words_of, ODD):
        assert name in total
        assert name in since
    assert {one.name for part in ("total", "since") for one in root.one(id=part).all()} <= {
        "h2", "p", "div", "table", "thead", "tbody", "tr", "th", "td", "b", "ul", "li"
    }  # fmt: skip


def test_odd_names_break_no_form_of_a_coverage():
    top = ET.fromstring(covered("junit"))  # noqa: S314 ours
    assert len(top) == 1 + len(ODD)
    rows = list(csv.DictReader(StringIO(covered("csv"), newline=""), strict=True))
    assert [row["language"].removeprefix("'") for row in rows[::2]] == [
        name.replace("\r", "\n").removeprefix("'") for name in ODD
    ]
    assert Coverage.model_validate_json(covered("json")) == odd_coverage()
