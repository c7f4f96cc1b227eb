"""The page of a line: complete, safe, small, and equal to the performance."""

import json
import re
import shutil
import subprocess
import zlib
from base64 import b64decode, b64encode
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from places import TESTS
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.performing.performer import PerformedLine
from lipsync_lang.studio.array_pack import NUMBER_TYPES, ArrayPack
from lipsync_lang.studio.line_page import line_page
from lipsync_lang.studio.module_bundle import bundle

NASTY = '</script><script>alert(1)</script><!-- <img src=x onerror=alert(1)> \u2028 \ud800 "'
NOISE = np.random.default_rng(0).integers(-32768, 32767, 22050).astype(np.int16)
MOST_BYTES = 3 * 2**20
"""Size limit of the page of a line on the shipped head."""

STATIC = Path(ll.__file__).parent / "studio" / "static"
OUTSIDE = re.compile(r"(?:src|href|action)\s*=|url\(|@import|https?:|//[\w.-]+\.\w", re.IGNORECASE)


def schedule(*texts):
    labels = ("P", "AY1", "B", "F", "UW1", "M")
    return ll.Schedule(
        labels, np.arange(len(labels) + 1) / 10,
        words=tuple(ll.Word(text, 2 * n, 2 * n + 2) for n, text in enumerate(texts)),
        notation="arpabet", audio=ll.Audio(NOISE, 22050),
    )  # fmt: skip


def performed(character="facefx", *texts):
    performer = ll.resolve("english", character)
    return performer.rigged(performer.perform(schedule(*(texts or ("pie", "boof")))))


@pytest.fixture(scope="module")
def animation():
    return performed()


@pytest.fixture(scope="module")
def page(animation):
    return line_page(animation)


class Elements(HTMLParser):
    """The elements of a page, with the texts of its scripts and styles."""

    def __init__(self, page):
        super().__init__(convert_charrefs=True)
        self.found, self.texts = [], []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))

    def handle_data(self, text):
        if self.found and text.strip():
            self.texts.append((*self.found[-1], text))

    def text(self, name, **traits):
        """Return the text of the only element of a kind."""
        (text,) = [
            text for tag, own, text in self.texts if tag == name and traits.items() <= own.items()
        ]
        return text


def data_of(page):
    """Return the document of a page, with its arrays in place."""
    elements = Elements(page)
    document = json.loads(elements.text("script", id="document"))
    block = zlib.decompress(b64decode(elements.text("script", id="block")))
    arrays, at = [], 0
    for kind, count in document["arrays"]:
        dtype = np.dtype(f"<{kind}")
        raw = np.frombuffer(block, np.uint8, count * dtype.itemsize, at)
        at += len(raw)
        if dtype.itemsize > 1 and dtype.kind != "f":
            steps = raw.reshape(dtype.itemsize, count).T.copy().view(f"<u{dtype.itemsize}")[:, 0]
            arrays.append(np.cumsum(steps, dtype=steps.dtype).view(dtype))
        else:
            arrays.append(raw.view(dtype))
    assert at == len(block)

    def filled(value):
        if isinstance(value, dict):
            own = {key: filled(one) for key, one in value.items()}
            return arrays[value["$array"]] if "$array" in value else own
        return [filled(one) for one in value] if isinstance(value, list) else value

    return filled(document)


# Whole and safe


def test_a_page_asks_for_nothing(page):
    elements = Elements(page)
    allowed = [("link", "data:,")]
    asked = [
        (tag, own[name])
        for tag, own in elements.found
        for name in ("src", "href", "action", "data", "poster", "srcset")
        if name in own
    ]
    assert asked == allowed
    assert not OUTSIDE.search(elements.text("style"))
    script = [text for tag, own, text in elements.texts if tag == "script" and not own]
    assert len(script) == 1
    assert not re.search(r"https?:|fetch\(|XMLHttp|WebSocket|import\(\"|innerHTML", script[0])


def test_the_policy_allows_the_own_script_and_style_and_no_request(page):
    elements = Elements(page)
    (policy,) = [
        own["content"] for tag, own in elements.found if own.get("http-equiv")
    ]  # fmt: skip
    rules = dict(one.strip().split(" ", 1) for one in policy.split(";"))
    (script,) = [text for tag, own, text in elements.texts if tag == "script" and not own]
    assert rules["default-src"] == "'none'"
    for name, text in (("script-src", script), ("style-src", elements.text("style"))):
        assert rules[name] == f"'sha256-{b64encode(sha256(text.encode()).digest()).decode()}'"
    assert "unsafe" not in policy


@pytest.mark.parametrize("hostile", [NASTY, "<script>", "]]>", "{{SCRIPT}}", "\u202eabc"])
def test_no_text_becomes_markup(hostile, page):
    times = np.arange(4) / 60
    other = performed("rhubarb")
    performer = other.source.performer
    poses = (*performer.poses, hostile, "b")
    odd = Animation(
        times, poses, np.zeros((4, len(poses))), 60, schedule(hostile, "boof"),
        PerformedLine(performer, {"line": hostile}),
        export=ExportSettings(against={hostile: other}),
    )  # fmt: skip
    made = line_page(odd)
    plain = [(tag, own.get("id")) for tag, own in Elements(page).found]
    assert [(tag, own.get("id")) for tag, own in Elements(made).found] == plain
    assert data_of(made)["takes"][0]["poses"][-2] == hostile
    assert data_of(made)["takes"][1]["name"] == hostile


def test_a_page_is_written_alike_each_time(page):
    again = performed()
    assert line_page(again) == page


def test_a_page_of_the_shipped_head_is_small(page):
    assert len(page.encode()) < MOST_BYTES / 3


def test_no_folder_of_this_machine_is_sent(page):
    assert str(Path.cwd()) not in page
    assert str(Path.home()) not in page.replace("/root/", "")


# What it holds


def test_curves_are_those_performed(animation, page):
    (take,) = data_of(page)["takes"]
    assert (take["start"], take["count"]) == (pytest.approx(animation.times[0]), len(animation))
    for pose, curve in zip(take["poses"], take["curves"], strict=True):
        shown = curve["low"] + (curve["high"] - curve["low"]) * curve["values"] / 65535
        np.testing.assert_allclose(shown, animation[pose], atol=1e-5)


def test_stages_end_where_the_animation_is(animation, page):
    (take,) = data_of(page)["takes"]
    making = take["making"]
    for row, pose in enumerate(making["moving"]):
        drawn = [stage["curves"][row] for stage in making["stages"]]
        last = [one for one in drawn if one is not None][-1]
        np.testing.assert_allclose(last / 65535, animation.weights[:, pose], atol=6e-4)


def test_findings_are_those_of_check(animation, page):
    (take,) = data_of(page)["takes"]
    quality = ll.check(animation)
    assert [one["name"] for one in take["figures"]] == [one.name for one in quality.figures]
    for told, figure in zip(take["figures"], quality.figures, strict=True):
        assert [what for _, what in told["findings"]] == [one.what for one in figure.findings]
        assert told["told"].endswith(".")
        assert "_" not in told["told"], "words, not names of code"


def test_no_two_stages_with_colours_alike_have_one_pattern(page):
    (take,) = data_of(page)["takes"]
    told = {one["name"]: one["hatch"] % 7 for one in take["making"]["stages"]}
    assert told["dial"] != told["limit"]


def test_a_rig_moves_the_model_and_poses_are_explained(tmp_path):
    animation = performed("facefx")
    model = glb(tmp_path / "jaw.glb", "other", bones=("jaw",))
    channel = ll.Channel("jaw", node="jaw", rotation=(1, 0, 0))
    turned = replace(
        animation, poses=("jaw",), channels=(channel,), weights=animation.weights[:, :1] * 20,
        model=model,
    )  # fmt: skip
    (take,) = data_of(line_page(turned))["takes"]
    assert take["poses"] == list(animation.poses)
    assert take["channels"]["poses"] == ["jaw"]
    (curve,) = take["channels"]["curves"]
    assert curve["high"] == pytest.approx(turned.weights.max())


def test_a_cut_animation_keeps_its_reasons(animation):
    (take,) = data_of(line_page(animation.cut()))["takes"]
    assert len(take["making"]["phoneme"]) == take["count"] == len(animation.cut())


def test_an_animation_of_another_program_has_curves_alone():
    times = np.arange(30) / 60
    plain = Animation(times, ("a", "b"), np.zeros((30, 2)), 60, schedule("pie"))
    data = data_of(line_page(plain))
    assert "making" not in data["takes"][0]
    assert data["faces"] == [{"unshown": []}]


def test_other_takes_are_beside_it(animation):
    other = ll.resolve("english", "rhubarb").perform(animation.schedule)
    data = data_of(line_page(replace(animation, export=ExportSettings(against={"letters": other}))))
    assert [take["name"] for take in data["takes"]] == ["", "letters"]
    assert [take["face"] for take in data["takes"]] == [0, 1]
    assert data["takes"][1]["poses"] == list(other.poses)


def test_a_model_that_cannot_be_drawn_is_told(animation, tmp_path):
    broken = tmp_path / "broken.glb"
    broken.write_bytes(b"glTF, or not")
    odd = replace(animation, model=broken)
    (face,) = data_of(line_page(odd))["faces"]
    assert list(face) == ["unshown"]
    assert face["unshown"][0].startswith("broken.glb: ")
    assert str(tmp_path) not in line_page(odd)
    assert "draws a simple mouth" in next(iter(WRITERS["html"].remarks(odd)))


# From the command line


@pytest.fixture
def line(tmp_path, monkeypatch):
    """Options of a line with timings of its own, and an animation of it."""
    monkeypatch.chdir(tmp_path)
    rows = [{"label": label, "start": n / 10, "end": (n + 1) / 10} for n, label in enumerate(
        ("P", "AY1", "B", "F", "UW1", "M"))]  # fmt: skip
    Path("line.timings.json").write_text(json.dumps(rows), "utf-8")
    options = ("-l", "english", "-c", "facefx", "--schedule", "line.timings.json")
    performed().save("old.json")
    return options


def read(path):
    return data_of(Path(path).read_text("utf-8"))


def test_a_line_is_compared_with_a_file_a_method_and_a_character(line, cli):
    others = ("old.json", "keyframes", "rhubarb")
    against = [word for one in others for word in ("--against", one)]
    done = cli("run", *line, "--cut", "-o", "line.html", *against)
    assert done.code == 0, done.err
    takes = read("line.html")["takes"]
    assert [take["name"] for take in takes] == ["", *others]
    assert [take["face"] for take in takes] == [0, 0, 0, 1]
    assert ["making" in take for take in takes] == [True, False, False, True]
    assert {take["count"] for take in takes} == {takes[0]["count"]}
    assert all(take["figures"] for take in takes)


def test_takes_move_the_model_that_is_named(line, cli, tmp_path):
    model = glb(tmp_path / "other.glb", "open", "W")
    done = cli("run", *line, "-o", "line.html", "--model", model, "--against", "held")
    assert done.code == 0, done.err
    assert [take["face"] for take in read("line.html")["takes"]] == [0, 0]


@pytest.mark.parametrize(
    ("outputs", "other", "told"),
    [
        (("-o", "line.csv"), "keyframes", "--against needs a page"),
        (("-o", "line.html"), "nobody", "not a file, a plain method .* or a character"),
        (("-o", "line.html"), "gone.json", "gone.json"),
    ],
)
def test_what_cannot_be_compared_is_told(line, cli, outputs, other, told):
    done = cli("run", *line, *outputs, "--against", other)
    assert done.code == 2
    assert re.search(told, done.err)
    assert not Path("line.html").exists()


def test_check_shows_its_findings_on_a_page(line, cli):
    done = cli("check", *line, "--baseline", "--limit", "speed=0.1", "-o", "line.html")
    assert done.code == 1
    takes = read("line.html")["takes"]
    assert [take["name"] for take in takes] == ["", "keyframes", "dominance", "held"]
    (speed,) = [one for one in takes[0]["figures"] if one["name"] == "speed"]
    assert speed["verdict"] == "FAIL"
    assert speed["findings"]


def test_check_shows_the_animation_of_another_program(line, cli):
    done = cli("check", *line[:4], "--animation", "old.json", "--format", "html", "-o", "old.html")
    assert done.code != 2, done.err
    (take,) = read("old.html")["takes"]
    assert "making" not in take
    assert take["figures"]
    assert "count" in read("old.html")["faces"][0]


@pytest.mark.parametrize(
    ("name", "begins"),
    [("a.json", "{"), ("a.xml", "<?xml"), ("a.HTML", "<!DOCTYPE html>"), ("a.txt", "english on")],
)
def test_the_suffix_tells_how_a_check_is_told(line, cli, name, begins):
    assert cli("check", *line, "-o", name).code != 2
    assert Path(name).read_text("utf-8").startswith(begins)
    assert cli("check", *line, "--format", "text", "-o", name).code != 2
    assert Path(name).read_text("utf-8").startswith("english on")


# Parts


@pytest.mark.parametrize("kind", NUMBER_TYPES)
def test_arrays_come_back(kind):
    pack = ArrayPack()
    dtype = np.dtype(f"<{kind}")
    rng = np.random.default_rng(1)
    whole = dtype.kind != "f"
    values = (
        rng.integers(np.iinfo(dtype).min, np.iinfo(dtype).max, 300, dtype, endpoint=True)
        if whole
        else rng.normal(size=300).astype(dtype)
    )
    assert pack.add(values, kind) == {"$array": 0}
    page = f'<script id="document">{json.dumps({"arrays": pack.layout(), "it": {"$array": 0}})}'
    page += f'</script><script id="block">{pack.text()}</script>'
    np.testing.assert_array_equal(data_of(page)["it"], values)


def test_copies_of_a_pack_go_on_apart():
    begun, found = ArrayPack(), []
    begun.add(range(1000), "u2")
    for number in (1, 2):
        pack = begun.copy()
        assert pack.add([number], "u1") == {"$array": 1}
        page = json.dumps({"arrays": pack.layout(), "it": [{"$array": 0}, {"$array": 1}]})
        page = f'<script id="document">{page}</script><script id="block">{pack.text()}</script>'
        found.append([one.tolist() for one in data_of(page)["it"]])
    assert found == [[[*range(1000)], [number]] for number in (1, 2)]
    assert begun.layout() == [["u2", 1000]]


def test_values_out_of_range_stay_at_its_end():
    pack = ArrayPack()
    pack.add([-1.0, 2.0], "u2", 65535)
    page = '<script id="document">{"arrays": [["u2", 2]], "it": {"$array": 0}}</script>'
    page += f'<script id="block">{pack.text()}</script>'
    assert data_of(page)["it"].tolist() == [0, 65535]


def test_a_bundle_has_each_module_once_and_after_what_it_imports():
    script = bundle("line/page")
    order = re.findall(r"^const \$(\w+) =", script, re.MULTILINE)
    assert len(order) == len(set(order))
    paths = {path.stem: path for path in STATIC.rglob("*.js")}
    assert len(paths) == len([*STATIC.rglob("*.js")]), "names of modules are unique"
    for name in order:
        source = paths[name].read_text("utf-8")
        imported = re.findall(r' from "\.[./\w]*/(\w+)\.js";\n', source)
        assert set(imported) <= set(order[: order.index(name)])
    assert order[-1] == "page"
    assert not re.search(r"^(?:import|export)\b", script, re.MULTILINE)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('import it from "./other.js";\n', "import"),
        ("export default 1;\n", "export"),
        ("const a = '</script>';\n", "</script"),
        ('import { a } from "./a.js";\n', "import each other"),
    ],
)
def test_what_cannot_be_bundled_is_refused(text, fault, monkeypatch):
    monkeypatch.setattr("lipsync_lang.studio.module_bundle.static", lambda _: text)
    with pytest.raises(ValueError, match=fault):
        bundle("a")


def test_a_name_that_a_module_does_not_export_cannot_be_imported(monkeypatch):
    modules = {"a": 'import { b, c } from "./other.js";\n', "other": "export const b = 1, c = 2;\n"}
    monkeypatch.setattr(
        "lipsync_lang.studio.module_bundle.static", lambda name: modules[name.removesuffix(".js")]
    )
    with pytest.raises(ValueError, match=r"other\.js.* c$"):
        bundle("a")


def test_the_writer_writes_the_page(animation, page):
    out = BytesIO()
    WRITERS["html"].write(animation, out)
    assert out.getvalue().decode() == page


# The scripts, in node


def node(*arguments):
    program = shutil.which("node") or pytest.skip("node is not installed")
    done = subprocess.run(
        [program, *map(str, arguments)], capture_output=True, encoding="utf-8", timeout=60,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_page_explains_as_the_command_does(animation, page, tmp_path):
    path = tmp_path / "line.html"
    path.write_text(page, "utf-8")
    frames = [3, 20, 25, 31, 40]
    script = TESTS / "browser" / "explain.mjs"
    told = node(script, STATIC, path, *frames)
    for frame, shown in zip(frames, told["frames"], strict=True):
        explained = animation.explain(float(animation.times[frame]))
        assert shown["label"] == explained.phoneme
        assert shown["common"] == explained.common
        assert [one["pair"] for one in shown["bigrams"]] == [
            "-".join(b.pair) for b in explained.bigrams
        ]
        for place, bigram in zip(shown["bigrams"], explained.bigrams, strict=True):
            assert place["position"] == pytest.approx(bigram.position, abs=1e-4)
        for pose in explained.poses:
            steps = [(s.stage, s.why) for s in pose.stages if s.why]
            assert [(s["stage"], s["why"]) for s in shown["poses"].get(pose.pose, [])] == steps


def test_the_page_plays_the_sound_of_the_schedule(animation, tmp_path):
    quiet, none = NOISE[:6000] // 512, np.zeros(300, np.int16)
    for number, samples in enumerate((NOISE, np.concatenate((quiet, none, NOISE[:100])), none[:0])):
        sounding = replace(animation.schedule, audio=ll.Audio(samples, 22050))
        path = tmp_path / f"{number}.html"
        path.write_text(line_page(replace(animation, schedule=sounding)), "utf-8")
        played = np.array(node(TESTS / "browser" / "explain.mjs", STATIC, path)["sound"], float)
        assert played.shape == samples.shape
        for at in range(0, len(samples), 256):  # the error follows the loudness
            block, error = samples[at : at + 256], (played - samples)[at : at + 256]
            assert abs(error).max() <= 0.5 + 0.05 * np.sqrt(np.mean(np.square(block, dtype=float)))


def test_the_units_of_the_scripts_hold():
    assert node(TESTS / "browser" / "units.mjs", STATIC) == {"failed": []}
