"""The import of the package is light: heavy libraries are imported only for use."""

import importlib
import json
import pkgutil
import subprocess
import sys
import typing

import pytest
from lanes import full, needs_plug_ins

import lipsync_lang as ll

HEAVY = {
    "jinja2",
    "numpy",
    "pydantic",
    "scipy",
    "ruamel.yaml",
    "matplotlib",
    "praatio",
    "espeakng_loader",
    "platformdirs",
    "http",
    "asyncio",
    "importlib.metadata",
}


def modules_after(code):
    """Return the modules that some code loads in a separate process."""
    command = f"import json, sys\n{code}\nprint(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    options = {"capture_output": True, "encoding": "utf-8", "check": True, "timeout": 60}
    done = subprocess.run([sys.executable, "-c", command], **options)  # noqa: PLW1510
    return set(json.loads(done.stderr.splitlines()[-1]))


BEFORE = modules_after("")
assert not HEAVY & BEFORE, "a sweep over what is there anyway passes"


@pytest.mark.parametrize(
    "code",
    [
        "import lipsync_lang",
        "import lipsync_lang; dir(lipsync_lang)",
        "import lipsync_lang.cli; lipsync_lang.cli.parser('run')",
        "from lipsync_lang import LipsyncError",
    ],
)
def test_importing_is_light(code):
    assert not HEAVY & modules_after(code)


@pytest.mark.parametrize("arguments", [["--help"], ["dance"], ["run", "--help"]])
def test_help_is_light(arguments):
    code = (
        "from lipsync_lang.cli import main\n"
        f"try: main({arguments!r})\n"
        "except SystemExit: print(file=sys.stderr)"
    )
    loaded = modules_after(code)
    assert not HEAVY & loaded
    assert not {one for one in loaded if one.startswith(("lipsync_lang.text.lines", "html"))}
    assert not {"hashlib", "lipsync_lang.packs.yaml.faults"} & loaded


@pytest.mark.parametrize(("stated", "used"), [(None, "4"), ("20", "20")])
def test_idle_threads_of_numpy_sleep_unless_the_user_says_otherwise(stated, used):
    code = (
        "import os, sys\n"
        "sys.argv = ['lipsync-lang', '--version']\n"
        "from lipsync_lang.__main__ import main\n"
        "name = 'OPENBLAS_THREAD_TIMEOUT'\n"
        f"os.environ.update({{name: {stated!r}}} if {stated!r} else {{}})\n"
        "try: main()\n"
        "except SystemExit: print(file=sys.stderr)\n"
        f"assert os.environ[name] == {used!r} and 'numpy' not in sys.modules"
    )
    assert "lipsync_lang.cli" in modules_after(code)


def test_the_end_of_the_program_looks_for_no_cycles():
    code = (
        "import atexit, gc, sys\n"
        "sys.argv, ends = ['lipsync-lang', '--version'], []\n"
        "atexit.register = ends.append\n"
        "from lipsync_lang.__main__ import main\n"
        "try: main()\n"
        "except SystemExit: print(file=sys.stderr)\n"
        "assert gc.freeze in ends"
    )
    loaded = modules_after(code)
    assert not {one for one in loaded if one.startswith("lipsync_lang.commands.run")}


def test_a_performer_is_made_without_the_readers_of_scripts_and_texts():
    loaded = modules_after("import lipsync_lang as ll; ll.resolve('english', 'facefx')")
    assert "lipsync_lang.text.lines.cleaning" in loaded
    assert "lipsync_lang.text.lines.markup" not in loaded
    assert "lipsync_lang.schedules.schedule" in loaded
    assert "lipsync_lang.schedules.rows" not in loaded
    assert "lipsync_lang.text.lines.line_readers" not in loaded
    assert "lipsync_lang.text.phonology.g2p.tokens" in loaded
    assert "lipsync_lang.text.phonology.g2p.corrections" not in loaded


@full
def test_performing_a_schedule_needs_no_speech_and_no_pictures():
    code = (
        "import lipsync_lang as ll\n"
        "schedule = ll.Schedule(('HH', 'AY'), [0, 0.1, 0.3])\n"
        "animation = ll.resolve('english', 'facefx').perform(schedule)\n"
        "animation.explain(0.1)"
    )
    rare = {"jinja2", "matplotlib", "praatio", "espeakng_loader", "http", "numpy.ma"}
    assert not rare & modules_after(code)


def test_a_run_loads_the_writers_of_its_files_alone(tmp_path):
    line, out = tmp_path / "line.csv", tmp_path / "out.csv"
    line.write_text("start,end,phoneme\n0,0.2,p\n0.2,0.4,a\n")
    run = ["run", "--schedule", str(line), "-l", "english", "-c", "facefx", "-o", str(out)]
    loaded = modules_after(f"from lipsync_lang.cli import main\nassert main({run!r}) == 0")
    assert out.stat().st_size
    rooms = ("lipsync_lang.animations.writers.", "lipsync_lang.plugins.programs.")
    assert {one for one in loaded if one.startswith(rooms)} == {f"{rooms[0]}csv"}
    idle = {"sound.speech.speaking.speaker", "performing.gesturing", "packs.yaml.faults"}
    assert not {f"lipsync_lang.{one}" for one in idle} & loaded


def test_a_report_from_the_cache_needs_no_arrays():
    resolve = ["resolve", "-l", "english", "-c", "facefx"]
    code = f"from lipsync_lang.cli import main\nassert main({resolve!r}) == 0"
    modules_after(code)
    ours = {f"lipsync_lang.packs.{one}" for one in ("library", "yaml.source", "yaml.faults")}
    unread = {"numpy", "pydantic", "ruamel.yaml", *ours}
    assert not unread & modules_after(code)


def readers_after(tmp_path, text):
    """Return the modules of readers that reading timings in JSON loads."""
    line = tmp_path / "line.json"
    line.write_text(text)
    loaded = modules_after(f"import lipsync_lang as ll; ll.read_schedule({str(line)!r})")
    rooms = ("lipsync_lang.plugins.timings.", "lipsync_lang.schedules.readers.")
    return {one.rpartition(".")[2] for one in loaded if one.startswith(rooms)}


def test_our_own_timings_load_no_readers_of_others(tmp_path):
    assert readers_after(tmp_path, '[{"label": "M", "start": 0, "end": 0.2}]') == {"json"}


@needs_plug_ins
def test_timings_in_json_load_no_readers_of_other_suffixes(tmp_path):
    loaded = readers_after(tmp_path, '{"mouthCues": [{"start": 0, "end": 0.2, "value": "A"}]}')
    assert {"rhubarb", "aeneas"} <= loaded
    assert not {"audacity", "elan"} & loaded


def test_a_build_of_texts_loads_nothing_that_hears(tmp_path):
    settings = "language: english\ncharacter: facefx\nlines: script.csv\noutputs: ['{id}.csv']\n"
    (tmp_path / "lipsync.yaml").write_text(f"kind: project\nformat: 1\n{settings}")
    (tmp_path / "script.csv").write_text("id,text\nl1,Buy more maps\n")
    build = "main(['build', '--workers', '1', '--tts', 'none'])"
    code = f"import os; os.chdir({str(tmp_path)!r})\nfrom lipsync_lang.cli import main\n"
    loaded = modules_after(f"{code}assert {build} == 0")
    assert (tmp_path / "l1.csv").stat().st_size
    hearing = "lipsync_lang.sound.speech.hearing."
    assert not {"faster_whisper", f"{hearing}recognition", f"{hearing}alignment"} & loaded
    again = build.replace("'none'", "'none', '--force'")
    assert "pydantic" not in modules_after(f"{code}assert {again} == 0"), "all packs are known"


@full
def test_resolving_builds_only_the_models_it_reads_and_parses_none_of_their_source():
    code = (
        "import lipsync_lang as ll\n"
        "ll.resolve('english', 'facefx', cache=False)\n"
        "from lipsync_lang.packs.models import MODELS, fields\n"
        "built = [kind for kind, model in MODELS.items() if model.__pydantic_complete__]\n"
        "assert 'poseset' in built and not {'rig', 'character'} & {*built}, built\n"
        "assert not fields._docstrings.cache_info().misses\n"
    )
    loaded = modules_after(code)
    assert "pydantic" in loaded


@pytest.mark.parametrize("name", ll.__all__)
def test_every_public_name_is_there(name):
    assert getattr(ll, name) is not None
    assert name in dir(ll)


def test_a_name_that_is_not_there_is_told():
    with pytest.raises(AttributeError, match="perfrom"):
        ll.perfrom  # noqa: B018 asking is the point


@full
def test_writers_load_nothing_of_the_network():
    code = "from lipsync_lang.animations.animation_writers import WRITERS; list(WRITERS)"
    assert not {"xml.sax", "urllib.request", "http", "ssl"} & modules_after(code)


def exported():
    """Public functions and classes of the package."""
    return [getattr(ll, name) for name in ll.__all__ if callable(getattr(ll, name))]


def raised():
    """All public errors of the package's modules."""
    for _, name, _ in pkgutil.walk_packages(ll.__path__, "lipsync_lang."):
        if not name.endswith("_worker"):
            importlib.import_module(name)
    ahead, found = [ll.LipsyncError], []
    while ahead:
        found.append(ahead.pop())
        ahead += found[-1].__subclasses__()
    return [one for one in found if one.__module__.startswith("lipsync_lang.")]


def classes_in(hint):
    """Yield the classes of the package in an annotation."""
    if isinstance(hint, type) and hint.__module__.startswith("lipsync_lang."):
        yield hint
    for inner in typing.get_args(hint):
        yield from classes_in(inner)


def test_every_error_is_exported():
    found = raised()
    own = {one.__name__ for one in found if one.__module__.startswith("lipsync_lang.studio.")}
    assert own, "answers of the studio's server, which no public function raises"
    own |= {"MissingReaderError"}  # a kind of SpeechError, for which another reader steps in
    own |= {
        "WrongTextError"
    }  # a kind of SpeechError, which counts against what another aligner hears
    own |= {"PlanningError"}  # of builds, which are commands and no public functions
    assert {one.__name__ for one in found} - own <= set(ll.__all__)


@pytest.mark.parametrize("function", [f for f in exported() if not isinstance(f, type)])
def test_every_type_that_a_function_returns_is_exported(function):
    names = {name: getattr(ll, name) for name in ll.__all__}
    returned = typing.get_type_hints(function, localns=names)["return"]
    found = {one.__name__ for one in classes_in(returned)}
    assert found, "public functions return something of ours"
    assert found <= set(ll.__all__)


def test_what_an_animation_tells_is_exported():
    animation = ll.resolve("english", "facefx").perform(ll.Schedule(("AA",), [0, 1]))
    told = [animation.explain(0.1), animation.source.performer.report, ll.check(animation)]
    told += [animation.source.performer.motion, *animation.channels, told[-1].figures[0]]
    assert {type(one).__name__ for one in told} <= set(ll.__all__)
