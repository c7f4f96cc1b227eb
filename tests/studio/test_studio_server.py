"""The studio's server: its checks of requests, its files, its pair and its line."""

import errno
import gzip
import hmac
import json
import sys
from contextlib import suppress
from pathlib import Path

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from lanes import swept
from studio_calls import HOST, TOKEN, Caller, unpacked

from lipsync_lang import studio
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.cli import main
from lipsync_lang.studio.desk import Desk
from lipsync_lang.studio.routes import line_routes
from lipsync_lang.studio.routes.requests import MAX_TEXT_CHARS, StudioRequest
from lipsync_lang.studio.routes.table import ROUTES
from lipsync_lang.studio.server import MAX_REQUEST_BYTES, app
from lipsync_lang.studio.workshop import Workshop

TIMES = b"""{"notation": "arpabet", "phonemes": [
    {"label": "M", "start": 0, "end": 0.1}, {"label": "AA", "start": 0.1, "end": 0.3}]}"""


@pytest.fixture(scope="module")
def workshop(tmp_path_factory):
    made = Workshop(tmp_path_factory.mktemp("project"), engine="none")
    made.open("english", "crab")
    return made


@pytest.fixture(scope="module")
def caller(workshop):
    return Caller(workshop)


def test_the_studio_is_served_with_a_strict_policy(caller):
    found = caller.get("")
    assert found.status == 200
    assert "script-src 'self'" in found.headers["content-security-policy"]
    assert "unsafe" not in found.headers["content-security-policy"]
    assert found.headers["referrer-policy"] == "no-referrer"
    assert b'src="studio.bundle.js"' in found.content
    script = caller.get("studio.bundle.js")
    assert script.status == 200
    assert b"class Studio" in gzip.decompress(script.content)


def test_every_module_of_the_studio_is_served(caller):
    folder = Path(studio.__file__).parent / "static"
    names = [path.relative_to(folder).as_posix() for path in folder.rglob("*.[jc]s*")]
    assert "shell/studio.js" in names
    for name in names:
        found = caller.get(name)
        assert (found.status, found.content) == (200, (folder / name).read_bytes())
        assert found.headers["content-type"].startswith("text/")


@pytest.mark.parametrize(
    "path",
    ["../server.py", "..%2fserver.py", "%2e%2e/server.py", "../../pyproject.toml", "/etc/passwd",
     "studio.html/../../server.py", "\\..\\server.py", "nothing.js", "shell",
     "shell/../shell/api.js", "shell/../../server.py", "__init__.py"],
)  # fmt: skip
def test_no_other_file_is_served(caller, path):
    assert caller.get(path).status == 404


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"host": "evil.example"}, 421),
        ({"host": "127.0.0.1:9"}, 421),
        ({"origin": "http://evil.example"}, 403),
        ({"origin": "null"}, 403),
        ({"origin": "http://["}, 403),
        ({"sec_fetch_site": "cross-site"}, 403),
        ({"content_length": str(MAX_REQUEST_BYTES + 1)}, 413),
        ({"content_length": "-1"}, 413),
    ],
)
def test_requests_of_others_are_refused(caller, headers, status):
    assert caller.get("api/state", **headers).status == status


@pytest.mark.parametrize("token", ["", "x", TOKEN[:-1], TOKEN + "x", "ä"])
def test_the_token_is_needed(caller, token):
    assert caller.ask("GET", f"/{token}/api/state").status == 404


def test_a_server_proves_that_it_knows_the_token(caller):
    found = caller.ask("GET", "/proof/some-text")
    assert (found.status, len(found.content)) == (200, 32)
    assert found.content == hmac.digest(TOKEN.encode(), b"some-text", "sha256")
    assert caller.ask("GET", "/proof/some-text", headers={"host": "evil.example"}).status == 421
    assert caller.ask("GET", "/proof/x", headers={"origin": "http://evil.example"}).status == 403


def test_other_machines_get_no_proof(workshop):
    """Tokens of people could be tried against it."""
    other = Caller(workshop)
    other.app = app(workshop, TOKEN, ["192.168.0.7:8000"])
    at = {"host": "192.168.0.7:8000"}
    assert other.ask("GET", "/proof/some-text", headers=at).status == 404
    assert other.ask("GET", f"/{TOKEN}/api/state", headers=at).status == 200


def test_the_studio_itself_may_ask(caller):
    same = {"origin": f"http://{HOST}", "sec_fetch_site": "same-origin"}
    assert caller.get("api/state", **same).json["character"] == "crab"


def test_a_request_without_a_length_is_limited(caller, monkeypatch):
    monkeypatch.setattr("lipsync_lang.studio.server.MAX_REQUEST_BYTES", 10)
    found = caller.ask("POST", f"/{TOKEN}/api/line", b"x" * 11, {"content-length": "0"})
    assert found.status == 413


@pytest.mark.parametrize(
    "body", [b"{", b"[]", b'"x"', b'{"text": 1}', b'{"text": NaN}', b"[" * 9999]
)
def test_a_body_that_is_no_request_is_told(caller, body):
    found = caller.post("line", body)
    assert found.status == 422
    assert "request" in found.json["error"]


LONE = "\ud800"
"""Half of a pair of UTF-16 units, which JSON can state and no file can hold."""

LONE_BODIES = {
    "open": {"language": LONE, "character": LONE},
    "edit": {
        "title": LONE, "tab": LONE, "merge": LONE,
        "edits": [{"file": "character", "at": ["title"], "value": f"a{LONE}b"}],
    },
    "undo": {"tab": LONE},
    "redo": {"tab": LONE},
    "save": {"keep": {json.dumps([LONE, "a"]): "mine"}},
    "line": {"text": f"hello {LONE} hello"},
    "take": {"settings": {"line": LONE, "styles": {LONE: 1}}, "against": LONE},
    "script": {"name": LONE},
    "emphasis/0": {"level": LONE},
    "part/0": {LONE: LONE},
    "times": {"times": [[LONE]]},
    "pose": {"weights": {LONE: 1}},
    "own": {LONE: LONE},
    "language/transcript": {"text": f"{LONE}hello"},
    "language/sound": {"notation": LONE, "label": LONE},
    "coverage": {"name": f"{LONE}.csv", "column": LONE},
}  # fmt: skip


POSTS = [route.removeprefix("POST ") for route in ROUTES if route.startswith("POST ")]
FELL = ("save", "emphasis/{name}", "language/transcript", "coverage", "edit", "script")


@pytest.mark.parametrize("route", swept(POSTS, quick=FELL))
def test_half_a_character_is_never_a_fault_of_the_studio(tmp_path, route):
    workshop = Workshop(tmp_path, engine="none", desk=Desk(tmp_path / "state/journal"))
    workshop.open("english", "crab")
    caller = Caller(workshop)
    caller.post("line", {"text": "hello"})
    path = route.replace("{name}", "0")
    body = LONE_BODIES.get(path, {"text": LONE, "name": LONE, "level": 1})
    for content in (body, TIMES.replace(b'"M"', b'"\\ud800"'), b"a\xed\xa0\x80"):
        for name in (f"{LONE}.json", "a.json", "a.csv", "a.po", "a.yarn", "a.wav", "a.glb"):
            query = {"name": name.encode("utf-8", "surrogatepass"), "text": b"\xed\xa0\x80"}
            answered = caller.post(path, content, query)
            assert answered.status != 500, (content, name)
    assert caller.post("save").status == 200
    assert caller.api("state").status == 200
    for name in (LONE, "%ED%A0%80"):
        assert caller.api(f"bigram/{name}").status == 422


@pytest.mark.parametrize("part", ["a/", "../", "a", "%", "\u0301", "っ"])
@pytest.mark.parametrize(
    ("route", "fields"),
    [
        ("coverage", ("name",)),
        ("script", ("name",)),
        ("open", ("language", "character")),
        ("language/sound", ("notation", "label")),
        ("language/transcript", ("text",)),
        ("line", ("text",)),
    ],
)
def test_a_long_text_is_bounded_work(workshop, route, fields, part):
    calls = 0

    def count(_frame, event, _argument):
        nonlocal calls
        calls += event in ("call", "c_call")

    for size in (10, MAX_TEXT_CHARS, 100 * MAX_TEXT_CHARS):  # the first reads what is kept
        body = {"notation": "ipa"} | dict.fromkeys(fields, part * (size // len(part)))
        request = StudioRequest(content=json.dumps(body).encode())
        sys.setprofile(count if size > 10 else None)
        try:
            with pytest.raises(LipsyncError) if size > 10 else suppress(LipsyncError):
                ROUTES[f"POST {route}"](workshop, request)
        finally:
            sys.setprofile(None)
    assert calls < 20 * MAX_TEXT_CHARS
    with pytest.raises(LipsyncError, match="more than 10,000 characters; shorten it"):
        StudioRequest(query={"text": part * MAX_TEXT_CHARS + "a"})


def test_a_name_of_a_script_that_no_file_can_have_is_told(caller):
    found = caller.post("coverage", {"name": "a" * 1000 + ".csv"})
    assert (found.status, found.json["error"][:18]) == (422, "there is no file '")


def test_text_that_enters_is_valid_unicode():
    request = StudioRequest(LONE, {LONE: "\ud83d\ude00"}, b'{"a": ["\\ud800", "\\ud83d\\ude00"]}')
    assert (request.name, request.query) == ("\ufffd", {"\ufffd": "😀"})
    assert request.body == {"a": ["\ufffd", "😀"]}


def test_the_project_lists_every_language_and_character(caller):
    told = caller.api("project").json
    assert {"english", "german"} <= {*told["languages"]}
    assert {"crab", "facefx"} <= {*told["characters"]}
    assert told["state"]["poses"][0] == {
        "name": "mouthOpen", "title": "lower shell dropped and mouth gaping", "region": "jaw",
    }  # fmt: skip


def test_a_line_is_read_and_performed(caller):
    found = caller.post("timings", TIMES, {"name": "line.json"})
    document, size = unpacked(found)
    assert document["takes"][0]["spoken"]["labels"] == ["M", "AA"]
    assert sum(count * int(kind[1]) for kind, count in document["arrays"]) == size
    again, _ = unpacked(caller.post("take", {"settings": {"fps": 30}, "against": "keyframes"}))
    assert [take["fps"] for take in again["takes"]] == [30, 30]
    assert caller.api("figures").json["figures"]


def test_a_line_is_spoken_without_a_voice(caller):
    document, _ = unpacked(caller.post("line", {"text": "*Map* room"}))
    assert [word[0] for word in document["takes"][0]["spoken"]["words"]] == ["Map", "room"]
    assert document["sound"] is None
    assert document["text"] == "*Map* room"


@pytest.mark.parametrize(
    ("body", "told"),
    [({"settings": {"colour": 1}}, "settings"), ({"against": "nobody"}, "nobody"),
     ({"settings": {"styles": {"silly": 1}}}, "silly"), ({"settings": []}, "object"),
     ({"settings": {"fps": "x"}}, "numbers"), ({"settings": {"fps": 0}}, "frames"),
     ({"settings": {"dials": {"jaw": [[0, 1], 3]}}}, "list"),
     ({"settings": {"dials": {"jaw": [[0]]}}}, "jaw"), ({"settings": {"dials": 3}}, "dials"),
     ({"settings": {"line": "none"}}, "none"), ({"settings": {"line": ["x"]}}, "line")],
)  # fmt: skip
def test_a_take_that_cannot_be_is_told(caller, workshop, body, told):
    caller.post("line", {"text": "Map room"})
    before = workshop.settings
    found = caller.post("take", body)
    workshop.settings = before
    assert found.status == 422
    assert told in found.json["error"]


@pytest.mark.parametrize("name", ["", "..", "a\0b", "x.nothing"])
def test_a_file_of_no_name_or_form_is_told(caller, name):
    assert caller.post("timings", b"nothing", {"name": name}).status == 422


def test_a_sent_file_in_another_encoding_has_one_cure(caller):
    content = "label,start,end\nÄ,0,1\n".encode("cp1252")
    assert caller.post("timings", content, {"name": "a.csv"}).json["error"].endswith("as UTF-8")


def test_a_sent_file_stays_in_its_folder(workshop, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    line_routes.timings(
        workshop, StudioRequest(query={"name": "../../../over.json"}, content=TIMES)
    )
    line_routes.timings(workshop, StudioRequest(query={"name": "..\\..\\over.json"}, content=TIMES))
    assert list(tmp_path.iterdir()) == []


def test_the_face_is_sent_with_a_take_of_rest(caller):
    document, _ = unpacked(caller.api("face"))
    assert document["face"]["parts"]
    assert document["take"]["poses"][0] == "mouthOpen"


def test_a_fault_of_the_program_shows_no_traceback(caller, monkeypatch):
    def fail(*_):
        raise ZeroDivisionError("secret")

    monkeypatch.setattr(Workshop, "state", fail)
    found = caller.api("state")
    assert found.status == 500
    assert b"secret" not in found.content


def test_a_disk_that_is_full_is_told(caller, monkeypatch):
    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device", "bank.yaml")

    monkeypatch.setattr(Workshop, "state", fail)
    found = caller.api("state")
    assert found.status == 500
    assert found.json["error"].startswith("bank.yaml: No space left on device")


def test_another_pair_is_opened_or_refused(tmp_path):
    caller = Caller(Workshop(tmp_path, engine="none"))
    state = caller.api("state").json
    assert (state["language"], state["character"], state["unsaved"]) == ("", "", [])
    assert unpacked(caller.api("face"))[0]["face"] is None
    assert "choose a language" in caller.post("line", {"text": "Hello"}).json["error"]
    assert caller.post("open", {"language": "german", "character": "crab"}).status == 200
    assert caller.api("figures").json == {"figures": []}  # the page may ask early
    found = caller.post("open", {"language": "germany", "character": "crab"})
    assert "german" in found.json["error"]
    assert caller.api("state").json["language"] == "german"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--host", "::"], "--token"),
        (["--token", "short"], "at least"),
        (["--token", "with/slashes/and/more"], "letters"),
        (["--port", "99999"], "65535"),
        (["--host", "no.such.host.invalid", "--token", "t" * 20], "cannot be used"),
    ],
)
def test_options_that_cannot_be_are_told(capsys, tmp_path, monkeypatch, arguments, told):
    monkeypatch.chdir(tmp_path)
    assert main(["studio", *arguments]) != 0
    assert told in capsys.readouterr().err


def test_a_pair_and_a_line_are_proposed_and_the_users_own_packs_come_first(tmp_path):
    caller = Caller(Workshop(tmp_path, engine="none"))
    tours = caller.api("project").json["tours"]
    found = caller.api("project").json["first"]
    tour = caller.api(f"tour/{tours[0]}").json
    assert found == {
        "language": tour["language"], "character": tours[0], "line": tour["line"],
    }  # fmt: skip
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages/stage.yaml").write_text(
        "kind: language\nformat: 1\nname: stage\ntag: en-x-stage\nextends: english\n"
        "tests:\n  - {text: maps and boats, phonemes: [bmp]}\n  - {text: a, phonemes: [ah]}\n"
    )
    (tmp_path / "characters").mkdir()
    (tmp_path / "characters/hero.yaml").write_text(
        "kind: character\nformat: 1\nname: hero\nposeset: facefx\n"
    )
    caller = Caller(Workshop(tmp_path, engine="none"))
    first = caller.api("project").json["first"]
    assert first == {"language": "stage", "character": "hero", "line": "maps and boats"}


def test_a_pair_that_is_named_begins_with_a_line_in_its_language(tmp_path):
    workshop = Workshop(tmp_path, engine="none")
    caller = Caller(workshop)
    told = caller.api("project").json["first"]
    workshop.open(told["language"], "facefx")
    assert caller.api("project").json["first"] == {**told, "character": "facefx"}
    workshop.open("german", "facefx")
    line = caller.api("project").json["first"]["line"]
    assert line in {test.text for test in workshop.library().language("german").model.tests}
