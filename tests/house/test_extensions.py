"""Plug-ins: extensions of installed distributions, refusals, and their cost."""

import os
import sys
import warnings
from itertools import chain
from pathlib import Path

import pytest
from lanes import full, needs_plug_ins
from test_import_is_light import modules_after

from lipsync_lang.animations.animation_readers import ANIMATION_READERS
from lipsync_lang.animations.animation_writers import WRITERS, find_writer, writer
from lipsync_lang.base import extensions
from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.base.extensions import Extensions, PluginWarning, installed
from lipsync_lang.base.grouping import grouped
from lipsync_lang.cli import main
from lipsync_lang.commands.registry import COMMANDS
from lipsync_lang.reports.coverage.forms import FORMS
from lipsync_lang.schedules.timing_readers import TIMING_READERS
from lipsync_lang.sound.speech import ENGINES as SPEECH_ENGINES
from lipsync_lang.sound.speech.hearing.align.aligners import ALIGNERS
from lipsync_lang.sound.speech.hearing.recognise.recognisers import RECOGNISERS
from lipsync_lang.sound.speech.hearing.sphinx.folder import MODEL_READERS
from lipsync_lang.text.lines.line_readers import LINE_READERS
from lipsync_lang.text.phonology.g2p import G2P_ENGINES, RESPELLERS

EVERY = (
    TIMING_READERS, LINE_READERS, ANIMATION_READERS, WRITERS, FORMS, G2P_ENGINES, RESPELLERS,
    SPEECH_ENGINES, ALIGNERS, RECOGNISERS, MODEL_READERS,
)  # fmt: skip
every_kind = pytest.mark.parametrize("known", EVERY, ids=lambda known: known.group)


@pytest.fixture
def known(monkeypatch):
    """A kind of extension for tests, with the built-in name `grey`."""
    made = Extensions("colours", "colour")
    made.add("grey", "built in", "lipsync_lang.colours")
    monkeypatch.setitem(sys.modules, "colours", type(sys)("colours"))
    sys.modules["colours"].KNOWN = made
    return made


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Install a distribution whose module registers colours."""

    def put(name, text, kind="colours"):
        folder = tmp_path / "site"
        module = f"{name}_plug_in"
        info = folder / f"{name}-1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[lipsync_lang.{kind}]\nany = {module}\n")
        (folder / f"{module}.py").write_text(text)
        if str(folder) not in sys.path:
            monkeypatch.syspath_prepend(folder)
        extensions._declared.cache_clear()  # noqa: SLF001 the folder has changed since
        monkeypatch.delitem(sys.modules, module, raising=False)

    yield put
    extensions._declared.cache_clear()  # noqa: SLF001


def adding(*names):
    lines = [f"KNOWN.add({name!r}, __name__, __name__)\n" for name in names]
    return "from colours import KNOWN\n" + "".join(lines)


def test_an_installed_plug_in_is_found_by_name(known, install):
    install("paint", adding("red"))
    assert known["red"] == "paint_plug_in"
    assert known.origins["red"] == "paint"
    assert list(known) == ["grey", "red"]


def test_built_in_names_are_answered_without_plug_ins(known, install):
    install("paint", "raise AssertionError('loaded too early')")
    assert known["grey"] == "built in"
    assert "grey" in known


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("import no_such_module_of_ours", "ModuleNotFoundError: No module named"),
        ("1 / 0", "ZeroDivisionError"),
        ("def broken(:", "SyntaxError"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        (adding("red") + "raise ValueError('half done')", "ValueError: half done"),
    ],
    ids=["missing", "raises", "syntax", "exits", "half"],
)
def test_a_broken_plug_in_is_named_and_left_out_whole(known, install, text, why):
    install("broken", text)
    install("paint", adding("blue"))
    with pytest.warns(PluginWarning, match=f"broken is left out: broken_plug_in .*{why}"):
        assert list(known) == ["grey", "blue"]
    with warnings.catch_warnings(action="error"):
        assert "red" not in known, "a plug-in is tried once"


def test_a_clash_names_both_distributions_and_the_first_wins(known, install):
    install("paint", adding("grey", "red"))
    install("tint", adding("red", "blue"))
    with pytest.warns(PluginWarning) as told:
        assert list(known) == ["grey", "red", "blue"]
    assert [str(one.message) for one in told] == [
        "colour 'grey' of paint is left out: lipsync-lang has the same name",
        "colour 'red' of tint is left out: paint has the same name",
    ]
    assert (known["grey"], known["red"]) == ("built in", "paint_plug_in")


def test_a_script_that_takes_a_known_name_is_refused(known):
    known.add("red", 1, "__main__")
    known.add("red", 2, "__main__")  # as a notebook does whose cell is run again
    assert known["red"] == 2
    with pytest.raises(
        LipsyncError, match="'red' of other is left out: __main__ has the same name"
    ):
        known.add("red", 3, "other.module")

    def mine(_animation, _out):
        pass

    mine.__module__ = "__main__"
    assert WRITERS.built_in()
    with pytest.raises(LipsyncError, match=r"'csv' of __main__ .* lipsync-lang has the same name"):
        writer("csv", suffix=".csv")(mine)


def test_a_built_in_name_is_kept_although_a_plug_in_was_imported_first(known):
    known.add("white", "early", "early_plug_in")
    with pytest.warns(
        PluginWarning, match="of early_plug_in is left out: lipsync-lang has the same name"
    ):
        known.add("white", "built in", "lipsync_lang.colours")
    assert known["white"] == "built in"
    assert known.origins["white"] == "lipsync-lang"


def test_an_unknown_name_tells_the_nearest_plug_ins_included(known, install):
    install("paint", adding("violet"))
    with pytest.raises(OutputError, match="unknown colour 'violett'; did you mean 'violet'"):
        known.find("violett", OutputError)


def test_a_plug_ins_longer_suffix_comes_before_a_built_in_one(install, monkeypatch, tmp_path):
    assert list(WRITERS)  # the copies below must not be the only ones that know a plug-in
    monkeypatch.setattr(WRITERS, "_plugged", False)
    for names in ("known", "origins"):
        monkeypatch.setattr(WRITERS, names, dict(getattr(WRITERS, names)))
    install(
        "takes",
        "from lipsync_lang.animations.animation_writers import writer\n"
        "@writer('take', suffix='.take.json')\n"
        "def write(animation, out):\n"
        "    'Takes.'\n",
        "writers",
    )
    assert find_writer(tmp_path / "line.json").name == "json"
    assert find_writer(tmp_path / "line.take.json").name == "take"


def test_a_plug_in_that_fails_in_use_is_named_without_a_traceback(
    install, monkeypatch, tmp_path, capsys
):
    assert list(WRITERS)  # the copies below must not be the only ones that know a plug-in
    monkeypatch.setattr(WRITERS, "_plugged", False)
    for names in ("known", "origins"):
        monkeypatch.setattr(WRITERS, names, dict(getattr(WRITERS, names)))
    install(
        "takes",
        "from lipsync_lang.animations.animation_writers import writer\n"
        "@writer('take', suffix='.take')\n"
        "def write(animation, out):\n"
        "    'Takes.'\n"
        "    raise KeyError('shoulder')\n",
        "writers",
    )
    monkeypatch.chdir(tmp_path)
    line = tmp_path / "line.csv"
    line.write_text("start,end,phoneme\n0,0.2,p\n0.2,0.4,a\n")
    options = ["run", "--schedule", str(line), "-l", "english", "-c", "facefx", "-o", "a.take"]
    assert main(options) == 2
    said = capsys.readouterr().err
    assert "the plug-in takes failed: KeyError: 'shoulder'" in said
    assert "Traceback" not in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["line.csv", "site"]


def test_the_writer_of_a_suffix_is_the_first_of_all_that_write_it():
    assert WRITERS.suffixes()
    for suffix in WRITERS.suffixes():
        path = Path(f"line{suffix}")
        assert find_writer(path) is WRITERS.ending(path)[0]


@every_kind
def test_what_is_built_in_is_there_under_its_name(known):
    # plug-ins alone read models of HTK, and respell texts
    alone = {"lipsync_lang.acoustic_models", "lipsync_lang.respellers"}
    assert known.built_in() or known.group in alone
    assert set(known.modules) <= set(known.built_in())
    assert set(known.origins.values()) <= {"lipsync-lang"}


@needs_plug_ins
def test_entry_points_of_our_readers_state_all_their_suffixes():
    stated = {one.module: one.name.split(".")[1:] for one in installed(TIMING_READERS.group)}
    made = grouped((one.read.__module__, one.suffixes) for one in TIMING_READERS.values())
    assert {*stated} < {*made}
    for module, ends in stated.items():
        assert {f".{end}" for end in ends} == {*chain.from_iterable(made[module])}, module


def test_kinds_have_groups_of_their_own():
    assert len({known.group for known in EVERY}) == len(EVERY)


@full
@pytest.mark.parametrize(
    "code",
    [
        "import lipsync_lang.animations.animation_writers as w; w.find_writer(Path('line.csv'))",
        "import lipsync_lang.schedules.timing_readers as r; r.read_schedule('line.json')",
        "from lipsync_lang.sound.speech import ENGINES\nENGINES['espeak']",
        "from lipsync_lang.sound.speech.hearing.align.aligners import ALIGNERS\nALIGNERS['warp']",
    ],
    ids=["writer", "reader", "engine", "aligner"],
)
def test_built_in_formats_and_engines_cost_no_entry_points(code, tmp_path, monkeypatch):
    (tmp_path / "line.json").write_text('{"phonemes": [{"label": "HH", "start": 0, "end": 0.1}]}')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))
    assert "importlib.metadata" not in modules_after(f"from pathlib import Path\n{code}")


EXAMPLE = "docs/examples/lipsync-lang-xsheet"


@pytest.mark.parametrize("module", ["exposure_sheet", "track_sheet", "metronome", "sheet_command"])
def test_the_how_to_shows_the_example(root, module):
    text = (root / EXAMPLE / f"lipsync_lang_xsheet/{module}.py").read_text("utf-8")
    page = (root / "docs/how-to/extend-it.md").read_text("utf-8")
    assert f"```py\n{text}```" in page
    assert f'"lipsync_lang_xsheet.{module}"' in (root / EXAMPLE / "pyproject.toml").read_text()
    assert f'"lipsync_lang_xsheet.{module}"' in page


def test_the_how_to_names_every_kind_that_is_open(root):
    page = (root / "docs/how-to/extend-it.md").read_text("utf-8")
    closed = {G2P_ENGINES.group: "packs name theirs by a list", RESPELLERS.group: "the same"}
    every = (*EVERY, COMMANDS)
    named = {known.group for known in every if f"`{known.group}`" in page}
    assert named == {known.group for known in every} - set(closed)
