"""The server of a study: stores valid answers, refuses others, and loses none."""

import http.client
import json
import socket
import threading
import time
from contextlib import closing, contextmanager, suppress

import pytest
from study_answers import submissions_in
from test_study_files import ANSWER, ANSWERS, STUDY

from lipsync_lang import LipsyncError
from lipsync_lang.plugins.study import answer_server as serving
from lipsync_lang.plugins.study.answer_server import AnswerServer
from lipsync_lang.plugins.study.study_file import MAX_SUBMISSION_BYTES, parse_document, texts_of

PAGE = f'<!DOCTYPE html><script type="application/json">{{"post":null,"study":"{STUDY["study"]}"'
JSON = {"Content-Type": "application/json"}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "study.json").write_text(json.dumps(STUDY))
    (tmp_path / "page.html").write_text(PAGE)
    (tmp_path / "secret.txt").write_text("secret")
    return tmp_path


@contextmanager
def served(folder, *origins):
    with AnswerServer(folder, "127.0.0.1", 0, origins) as server:
        thread = threading.Thread(target=server.run)
        thread.start()
        try:
            yield server.port
        finally:
            server.stop()
            thread.join()


def ask(port, method="GET", path="/", body=None, headers=None):
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=60)) as link:
        link.request(method, path, body, headers or {})
        answer, content = link.getresponse(), b""
        # A body that is refused unread resets the connection, maybe before the answer is read.
        with suppress(ConnectionResetError):
            content = answer.read()
        return answer.status, content, answer.headers


def post(port, content=None, **headers):
    body = json.dumps(content or ANSWERS) if not isinstance(content, bytes) else content
    return ask(port, "POST", "/answers", body, JSON | headers)


def test_the_page_posts_to_the_server_that_gives_it(folder):
    with served(folder) as port:
        status, page, headers = ask(port)
        assert ask(port, path="/page.html")[1] == page
        assert ask(port, "HEAD")[:2] == (200, b"")
    assert status == 200
    assert page.decode() == PAGE.replace('"post":null', '"post":"answers"')
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] == "no-store"
    assert "Access-Control-Allow-Origin" not in headers


def test_a_query_of_the_address_changes_nothing(folder):
    with served(folder) as port:
        assert ask(port, path="/page.html?rater=7")[1] == ask(port)[1]


def test_answers_are_appended_and_read_back(folder):
    (folder / "answers.jsonl").write_text(json.dumps(ANSWERS) + "\n")
    other = ANSWERS | {"rater": "0" * 16}
    with served(folder) as port:
        assert post(port, other)[:2] == (201, b'{"taken": true}')
        assert post(port, other)[0] == 200, "a browser may send twice"
        assert post(port, other | {"finished": "2026-11-23T07:00:00Z"})[0] == 201
    read = submissions_in(folder / "answers.jsonl")
    assert [one.rater for one in read] == [ANSWERS["rater"], "0" * 16, "0" * 16]
    with served(folder) as port:
        assert post(port, other)[0] == 200, "known after a restart"


@pytest.mark.parametrize("name", ["answers.jsonl", "page.html", "clips"])
def test_a_study_with_links_to_elsewhere_is_refused(folder, tmp_path_factory, name):
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(tmp_path_factory.mktemp("elsewhere"))
    with pytest.raises(LipsyncError, match=f"{name}: leads outside"):
        AnswerServer(folder, "127.0.0.1", 0)


def test_a_write_that_was_cut_off_spoils_no_answer_after_it(folder):
    (folder / "answers.jsonl").write_text('{"kind": "answers", "form')
    with served(folder) as port:
        assert post(port)[0] == 201
    texts = [text for _, text in texts_of([folder / "answers.jsonl"])]
    assert [parse_document(text)[0] for text in texts] == ["unreadable", ""]


def test_many_raters_at_once_lose_nothing(folder):
    raters = [f"{number:016x}" for number in range(24)]
    statuses = []
    with served(folder) as port:
        threads = [
            threading.Thread(
                target=lambda rater=one: statuses.append(post(port, ANSWERS | {"rater": rater})[0])
            )
            for one in raters
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert statuses == [201] * len(raters)
    read = submissions_in(folder / "answers.jsonl")
    assert sorted(one.rater for one in read) == raters


def test_answers_are_on_the_disk_before_they_are_taken(folder, monkeypatch):
    synced = []
    real = serving.os.fsync
    monkeypatch.setattr(serving.os, "fsync", lambda file: (synced.append(file), real(file)))
    with served(folder) as port:
        assert post(port)[0] == 201
    assert len(synced) == 1


def test_the_same_answers_sent_twice_at_once_are_one_line(folder, monkeypatch):
    monkeypatch.setattr(serving.os, "fsync", lambda _: time.sleep(0.3))
    statuses = []
    with served(folder) as port:
        threads = [threading.Thread(target=lambda: statuses.append(post(port)[0])) for _ in "ab"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert sorted(statuses) == [200, 201]
    assert len(submissions_in(folder / "answers.jsonl")) == 1


@pytest.mark.parametrize("path", [
    "/study.json", "/secret.txt", "/answers.jsonl", "/../secret.txt", "/%2e%2e/secret.txt",
    "/clips/", "//secret.txt", "/page.html/../secret.txt", "/answers", "/.", "/study.json?x",
])  # fmt: skip
def test_nothing_but_the_page_is_given(folder, path):
    with served(folder) as port:
        status, content, _ = ask(port, path=path)
    assert status == (405 if path == "/answers" else 404)
    assert b"secret" not in content


@pytest.mark.parametrize(("headers", "status"), [
    ({"Host": "evil.example"}, 421),
    ({"Host": ""}, 421),
    ({"Host": "[::1"}, 421),
    ({"Origin": "https://evil.example"}, 403),
    ({"Origin": "null"}, 403),
    ({"Content-Type": "text/plain"}, 415),
    ({"Content-Type": "application/x-www-form-urlencoded"}, 415),
    ({"Content-Length": "99999999999"}, 413),
    ({"Content-Length": str(MAX_SUBMISSION_BYTES + 1)}, 413),
    ({"Content-Length": "-1"}, 400),
    ({"Content-Length": "1e3"}, 400),
])  # fmt: skip
def test_requests_of_others_and_of_other_forms_are_refused(folder, headers, status):
    with served(folder) as port:
        assert post(port, **headers)[0] == status
    assert not (folder / "answers.jsonl").exists()


@pytest.mark.parametrize("content", [
    b"", b"[]", b"\xff", b"[" * 10_000, ANSWERS | {"study": "0" * 16}, ANSWERS | {"consent": False},
    ANSWERS | {"answers": [ANSWER | {"pair": "p009"}]}, ANSWERS | {"asked": {"name": "Anna"}},
    ANSWERS | {"more": "\n"},
])  # fmt: skip
def test_answers_that_are_none_of_the_study_are_refused(folder, content):
    with served(folder) as port:
        status, told, _ = post(port, content)
    assert status == 422
    assert json.loads(told)["error"]
    assert not (folder / "answers.jsonl").exists()


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "TRACE"])
def test_other_methods_are_not_known(folder, method):
    with served(folder) as port:
        assert ask(port, method, "/answers")[0] == 405


@pytest.mark.parametrize("origin", ["https://example.org", "null"])
def test_a_stated_origin_may_post(folder, origin):
    with served(folder, origin) as port:
        status, _, headers = preflight(port, origin)
        taken = post(port, Origin=origin)
        refused = preflight(port, "https://evil.example")
    assert (status, taken[0], refused[0]) == (200, 201, 400)
    assert headers["Access-Control-Allow-Origin"] == origin
    assert taken[2]["Access-Control-Allow-Origin"] == origin
    assert "Access-Control-Allow-Origin" not in refused[2]


def preflight(port, origin):
    """Ask as a browser asks before a page of another site posts."""
    asked = {
        "Access-Control-Request-Method": "POST",
        "Access-Control-Request-Headers": "content-type",
    }
    return ask(port, "OPTIONS", "/answers", headers={"Origin": origin} | asked)


def test_a_public_name_is_answered(folder):
    with served(folder, "https://example.org") as port:
        assert ask(port, headers={"Host": "example.org"})[0] == 200
        assert ask(port, headers={"Host": "example.com"})[0] == 421


POSTED = b"POST /answers HTTP/1.0\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"


@pytest.mark.parametrize("sent", [b"", b"GET / HT", POSTED + b"Content-Length: 500\r\n\r\n{"])
def test_a_slow_request_is_ended(folder, monkeypatch, sent):
    monkeypatch.setattr(serving, "REQUEST_SECONDS", 0.2)
    with served(folder) as port, closing(socket.create_connection(("127.0.0.1", port))) as link:
        link.settimeout(60)
        link.sendall(sent)
        told = b"".join(iter(lambda: link.recv(1000), b""))
        assert not told or b"408" in told or b"400" in told
    assert not (folder / "answers.jsonl").exists()


def test_a_client_that_takes_nothing_of_the_page_is_dropped(folder, monkeypatch):
    monkeypatch.setattr(serving, "SEND_SECONDS", 0.2)
    monkeypatch.setattr(serving, "MAX_CONNECTIONS", 1)
    (folder / "page.html").write_text(PAGE + "x" * 20_000_000)
    with served(folder) as port, closing(socket.create_connection(("127.0.0.1", port))) as link:
        link.sendall(b"GET / HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n")
        assert any(gives_the_page(port) for _ in range(200)), "its place comes back"


def test_connections_beyond_the_most_are_dropped(folder, monkeypatch):
    monkeypatch.setattr(serving, "MAX_CONNECTIONS", 2)
    with served(folder) as port:
        idle = [socket.create_connection(("127.0.0.1", port)) for _ in range(2)]
        time.sleep(0.2)
        with pytest.raises((OSError, http.client.HTTPException)):
            ask(port)
        for one in idle:
            one.close()
        assert any(gives_the_page(port) for _ in range(200)), "the places come back"


def gives_the_page(port):
    """Return True if a server has a free place, and wait a moment if it is full."""
    try:
        return ask(port)[0] == 200
    except (OSError, http.client.HTTPException):
        time.sleep(0.05)
        return False


def test_an_address_may_not_flood_the_file(folder, monkeypatch):
    monkeypatch.setattr(serving, "MAX_PER_MINUTE", 2)
    with served(folder) as port:
        statuses = [post(port, ANSWERS | {"rater": f"{n:016x}"})[0] for n in range(3)]
    assert statuses == [201, 201, 429]


def test_a_full_file_takes_no_more(folder, monkeypatch):
    monkeypatch.setattr(serving, "MAX_ANSWERS_BYTES", 1000)
    with served(folder) as port:
        statuses = [post(port, ANSWERS | {"rater": f"{n:016x}"})[0] for n in range(3)]
    assert statuses[0] == 201
    assert statuses[-1] == 507
    assert (folder / "answers.jsonl").stat().st_size <= 1000


def test_a_file_that_cannot_be_written_is_told(folder):
    with served(folder) as port:
        (folder / "answers.jsonl").mkdir()
        assert post(port)[0] == 507


@pytest.mark.parametrize(("spoil", "told"), [
    (lambda f: (f / "study.json").unlink(), "study.json: cannot be read"),
    (lambda f: (f / "page.html").unlink(), "page.html: cannot be read"),
    (lambda f: (f / "page.html").write_text("other"), "is the page of another study"),
    (lambda f: (f / "answers.jsonl").mkdir(), "answers.jsonl: cannot be read"),
])  # fmt: skip
def test_a_folder_without_a_whole_study_is_refused(folder, spoil, told):
    spoil(folder)
    with pytest.raises(LipsyncError, match=told):
        AnswerServer(folder, "127.0.0.1", 0)


@pytest.mark.parametrize(("host", "port", "origins", "told"), [
    ("127.0.0.1", 99999, (), "give a number from 1 to 65535"),
    ("no such host", 0, (), "cannot be used"),
    ("127.0.0.1", 0, ("example.org",), "is not a web address"),
])  # fmt: skip
def test_an_address_that_cannot_be_served_is_refused(folder, host, port, origins, told):
    with pytest.raises(LipsyncError, match=told):
        AnswerServer(folder, host, port, origins)


def test_the_command_prints_the_address_and_refuses_a_folder_without_a_study(folder, cli):
    done = cli("study", "serve", folder / "nowhere")
    assert done.code == 2
    assert "study.json: cannot be read" in done.err
