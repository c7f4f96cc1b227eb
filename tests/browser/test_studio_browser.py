"""The studio in a browser, used as an animator would use it."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from lanes import full
from ruamel.yaml import YAML
from shipped import LIBRARY
from test_consumers import chromium, found

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.production.builds.project_folder import starter

pytest.importorskip("uvicorn", reason="the studio needs uvicorn")
pytestmark = full

HERE = Path(__file__).parent
BANK = Path("posesets") / "crab" / "banks" / "common.yaml"
TOKEN = "a-token-for-the-tests"  # noqa: S105 of a server that nobody else reaches


class Studio:
    """A studio, or another page of a command, in its own process and its own folder."""

    command = ("studio",)

    def __init__(self, folder, *arguments):
        self.folder, self.arguments = folder, arguments
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.process = None
        self.token = True

    def start(self):
        at = ("--token", TOKEN, "--port", str(self.port)) if self.token else ()
        command = [
            sys.executable, "-m", "lipsync_lang", *self.command, "--no-browser", *at,
            *self.arguments,
        ]  # fmt: skip
        state = os.environ | {"XDG_STATE_HOME": str(self.folder.parent / "state")}
        self.process = subprocess.Popen(
            command, cwd=self.folder, env=state, stdout=subprocess.PIPE, encoding="utf-8"
        )
        self.address = self.process.stdout.readline().split()[-1]

    def kill(self, how=signal.SIGKILL):
        if self.process is not None:
            self.process.send_signal(how)
            self.process.wait(timeout=60)
            self.process.stdout.close()
            self.process = None


@pytest.fixture
def studio(tmp_path, request):
    folder = tmp_path / "project"
    folder.mkdir()
    made = Studio(folder, *getattr(request, "param", ("-l", "english", "-c", "crab")))
    made.start()
    yield made
    made.kill()


class Story:
    """A script that runs in the browser; the test can act between its parts."""

    def __init__(self, studio, name):
        node, modules = found("playwright-core")
        pictures = os.environ.get("LIPSYNC_LANG_STUDIO_PICTURES", "")
        self.process = subprocess.Popen(
            [node, HERE / "studio.mjs", modules, chromium(), studio.address, name, pictures],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8",
        )  # fmt: skip

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def line(self):
        return self.process.stdout.readline().strip()

    def go_on(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def end(self):
        """Return the results of the script, after a check for errors and foreign requests."""
        out, errors = self.process.stdout.read(), self.process.stderr.read()
        self.process.wait(timeout=300)
        if self.process.returncode:
            pytest.fail(f"exit code {self.process.returncode}: {errors}", pytrace=False)
        told = json.loads(out)
        assert (told["said"], told["asked"]) == ([], [])
        return told


def telling(studio, name):
    with Story(studio, name) as story:
        return story.end()


def test_a_line_is_heard_seen_explained_shaped_and_saved(studio):
    told = telling(studio, "walk")
    assert told["moved"] > 20
    assert told["heard"] == sorted(told["heard"])
    assert told["heard"][-1] > told["heard"][0]
    assert told["after"] != told["before"]
    assert told["undone"] == told["before"]
    assert told["saved"] == told["after"]
    text = (studio.folder / BANK).read_text("utf-8")
    assert "w-bmp" in text
    assert "approved" in text
    performer = resolve("english", "crab", paths=[studio.folder], cache=False)
    assert ("w", "bmp") in [
        origin.pair for origin in performer.compiled.origins if origin.status == "approved"
    ]


def test_everything_is_reached_by_keys(studio):
    told = telling(studio, "keyboard")
    assert told["stepped"] != told["clock"]
    assert told["hash"].startswith("#bigrams/")
    assert told["after"] != told["before"]
    assert told["keys"] > 10
    assert told["nameless"] == []


def test_two_tabs_a_changed_file_and_a_killed_server(studio):
    found("axe-core")
    with Story(studio, "trouble") as story:
        assert story.line() == "edited"
        file = studio.folder / BANK
        text = file.read_text("utf-8")
        file.write_text(
            text.replace("]]", "], [1, 0.123]]", 1).replace("[1, 0], [1", "[1"), "utf-8"
        )
        assert file.read_text("utf-8") != text
        story.go_on()
        assert story.line() == "kill"
        studio.kill()
        studio.start()
        story.go_on()
        told = story.end()
    assert told["shared"]
    assert told["found"] == [], "axe-core finds nothing in the conflict"
    assert "w-bmp" in told["conflict"]
    assert ["mouthOO", "mine", "theirs"] in told["drawn"]
    assert told["kept"]


def test_two_tabs_on_one_line_follow_each_other(studio):
    assert telling(studio, "tabs")["character"] == "facefx"


def test_the_page_goes_on_after_a_killed_server(studio):
    """With the address that the studio chose, and kept for its next start."""
    studio.kill()
    studio.token = False
    studio.start()
    kept = next((studio.folder.parent / "state").rglob("*.address"))
    assert kept.stat().st_mode & 0o777 == 0o600
    address = studio.address
    with Story(studio, "killed") as story:
        assert story.line() == "kill"
        studio.kill()
        story.go_on()
        assert story.line() == "start"
        studio.start()
        assert studio.address == address
        story.go_on()
        told = story.end()
    (lost,), (found,) = told["lost"], told["found"]
    assert lost.startswith("The studio has stopped. Start it again in its folder")
    assert "goes on with your unsaved edits (1)" in found
    assert (told["text"], told["level"]) == ("Bob bumps my blue boat.", "1.7")
    (file,) = studio.folder.rglob("characters/crab.yaml")
    assert "1.7" in file.read_text("utf-8")


LACKING = """kind: project
format: 1
languages: [english]
lines: lines.csv
audio: "vo/{id}.flac"
cast: {"*": crab}
outputs: "takes/{id}.html"
reports: build/report.xml
"""


@pytest.mark.parametrize("studio", [()], indirect=True)
def test_a_word_left_out_is_said_and_a_build_keeps_it(studio, data):
    pytest.importorskip("pocketsphinx")
    studio.kill()
    recording = data / "recordings" / "mfa_tests" / "61-70968-0000.flac"
    text = recording.with_suffix(".lab").read_text("utf-8").strip().lower()
    lines = f"id,speaker,text\na01,Bob,{text.replace('wizard', 'tremendous wizard')}\n"
    (studio.folder / "vo").mkdir()
    shutil.copy(recording, studio.folder / "vo" / "a01.flac")
    (studio.folder / "lines.csv").write_text(lines, "utf-8")
    (studio.folder / "lipsync.yaml").write_text(LACKING, "utf-8")
    command = [sys.executable, "-m", "lipsync_lang", "build", "--json", "--workers", "1"]

    def left_out():
        done = subprocess.run(command, cwd=studio.folder, check=True, capture_output=True)
        line = json.loads(done.stdout.splitlines()[0])
        listed = "lacks tremendous" in (studio.folder / "build/report.xml").read_text("utf-8")
        shown = (studio.folder / "takes/a01.html").read_text("utf-8")
        return line["left_out"], listed, '"left_out":["tremendous"]' in shown

    assert left_out() == (["tremendous"], True, True)
    studio.start()
    told = telling(studio, "lacking")
    assert told["why"] == "Not heard in the sound, so the mouth does not say them."
    assert told["lines"] == [["tremendous"], [], ["tremendous"], []]
    assert "the *tremendous* wizard" in told["marked"]
    assert left_out() == ([], False, False)


@pytest.mark.parametrize("studio", [()], indirect=True)
def test_the_tour_of_the_crab(studio):
    found("axe-core")
    told = telling(studio, "tour")
    tour = json.loads((LIBRARY.find("poseset", "crab").parent / "tour.json").read_bytes())
    assert (told["pair"], told["line"]) == ([tour["language"], "crab"], tour["line"])
    assert told["seen"]
    assert told["found"] == [], "axe-core finds nothing in the tour"
    assert told["titles"] == [step["title"] for step in tour["steps"]]
    assert (told["outside"], told["left"], told["focus"]) == ([], 0, "text")
    assert (told["again"], told["view"]) == (told["titles"][0], "sentence")


def test_a_character_is_posed_seen_through_and_edited(studio):
    told = telling(studio, "character")
    assert told["slid"] > 20
    assert told["through"] > 20
    assert told["solid"] == 0
    assert "never above it" in told["rule"]
    assert told["pictured"] == 8
    assert told["shown"] == "0.75"
    assert told["ranks"][:3] == ["frown", "smile", "bareTeeth"]
    assert told["thresholds"] == ["1", "0.8"], "a drag is one step of undo"
    assert "Rank of smile" in told["title"]
    assert told["posed"] > 20
    character = YAML(typ="safe").load(studio.folder / "characters/crab.yaml")
    [stated] = LIBRARY.common().model.phonemes["w"].mouth
    assert character["mouths"] == {
        "w": stated.model_dump(exclude_defaults=True) | {"aperture": 0.31}
    }
    assert told["nameless"] == 0
    poseset = studio.folder / "posesets/crab/poseset.yaml"
    lines = poseset.read_text("utf-8").splitlines()
    before = LIBRARY.find("poseset", "crab").read_text("utf-8").splitlines()
    changed = [line.partition("    #")[0] for line in lines if line not in before]
    assert changed == [
        "priority: [frown, smile, bareTeeth, mouthOO] ",
        "  aa:  {mouthOpen: 0.9, smile: 0.3}",
    ]


def test_every_view_fits_every_screen(studio):
    assert telling(studio, "views")["overflow"] == []


def test_a_face_has_its_own_window_and_a_video_in_step(studio):
    seen = telling(studio, "beside")
    assert (seen["follows"], seen["apart"]) == (True, 0)


def test_the_splitter_moves_by_keys_and_by_drags(studio):
    seen = telling(studio, "splitter")
    one, two, back, most, least = seen["widths"]
    assert least < seen["usual"] < one == back < two < most
    assert seen["stated"] == "11"
    assert abs(seen["dragged"] - 200) < 5
    assert seen["again"] == seen["usual"]


def test_a_second_character_says_the_line_as_it_is_delivered(studio):
    assert telling(studio, "second")["left"] == 1


def test_axe_finds_nothing_in_any_view(studio):
    found("axe-core")
    assert telling(studio, "axe")["found"] == []


def script(folder, count=1000):
    """Write a project of many lines in two languages, for two faces."""
    numbers = range(1, count + 1)
    rows = [f"line_{n:04},{'Bob' if n % 2 else 'Eve'},Line {n}.,Rivi {n}." for n in numbers]
    table = "\n".join(["id,speaker,english,finnish", *rows])
    (folder / "lines.csv").write_text(table, "utf-8")
    (folder / "lipsync.yaml").write_text(
        "kind: project\nformat: 1\nlanguages: [english, finnish]\nlines: lines.csv\n"
        'cast: {Bob: crab, "*": facefx}\noutputs: "takes/{language}/{character}/{id}.csv"\n'
    )


@pytest.mark.parametrize("studio", [("--tts", "none")], indirect=True)
def test_the_lines_of_a_script_are_opened_one_by_one(studio):
    script(studio.folder)
    studio.kill()
    studio.start()
    told = telling(studio, "script")
    assert told["first"] == ["line_0001 · 1 of 1000", "Line 1.", "crab"]
    assert told["second"] == ["line_0002 · 2 of 1000", "Line 2.", "facefx"]
    assert told["ends"] == [True, False]
    assert (told["listed"], told["more"], told["found"]) == (100, 200, ["line_0987"])
    assert told["chosen"] == ["line_0987 · 987 of 1000", "Line 987.", "crab"]
    assert told["again"] == told["chosen"]
    assert told["other"] == ["line_0987 · 987 of 1000", "Rivi 987.", "crab"]
    assert told["typed"] == "Lines (1000)"
    assert told["wide"] <= 0


@pytest.mark.parametrize("studio", [("--tts", "none")], indirect=True)
def test_lines_are_exported(studio):
    script(studio.folder, 3)
    studio.kill()
    studio.start()
    told = telling(studio, "exports")
    assert sorted(told["formats"]) == sorted(WRITERS)
    assert {*told["files"]} == {"line_0001.csv", "line_0001.html"}
    assert min(told["files"].values()) > 1000
    assert told["told"].startswith("Exported 6 files: exports/crab/line_0001.csv")
    assert len([*(studio.folder / "exports").rglob("*.*")]) == 6
    assert told["kept"] == ["csv", "html"]


def test_a_new_project_is_made_built_and_opened(studio):
    """The commands of a new project's README, one after the other."""
    studio.kill()
    folder = studio.folder.parent
    run = [sys.executable, "-m", "lipsync_lang"]
    subprocess.run([*run, "new", "my-game"], cwd=folder, check=True)
    game = folder / "my-game"
    readme = (game / "README.md").read_text("utf-8")
    commands = re.findall(r"^\$ lipsync-lang (.+)$", readme, re.MULTILINE)
    assert commands == ["doctor", "validate", "build", "studio"]
    subprocess.run([*run, "validate", "--no-tests"], cwd=game, check=True)
    subprocess.run([*run, "build", "--tts", "none", "--workers", "1"], cwd=game, check=True)
    studio.folder, studio.arguments = game, ("--tts", "none")
    studio.start()
    told = telling(studio, "start")
    assert told["line"] == "line_01 · 1 of 3"
    assert (told["text"], told["pair"][1]) == (starter().lines[0], starter().name)
    assert told["drawn"]


def test_ctrl_c_closes_the_studio(studio):
    process = studio.process
    with urllib.request.urlopen(studio.address) as answer:  # noqa: S310 it listens to signals now
        assert answer.status == 200
    studio.kill(signal.SIGINT)
    assert process.returncode == 0
