"""Builds: the lines that are made, the reasons, and the files that never change."""

import os
import pickle
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from shutil import copytree, rmtree
from zipfile import ZipFile

import numpy as np
import pytest
from build_project import PROJECT, SOUNDS, Game, left_behind
from lanes import needs_plug_ins, swept
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation_readers import read_animation
from lipsync_lang.cli import main
from lipsync_lang.commands import build as build_command
from lipsync_lang.production.builds import build_run, keeping, making, needs, records, workers
from lipsync_lang.production.builds.archives import rewrite
from lipsync_lang.production.builds.build_tally import BuildTally
from lipsync_lang.production.builds.making import LineBatch
from lipsync_lang.production.builds.project_build import ProjectBuild
from lipsync_lang.production.builds.records import NEED, Records, as_json
from lipsync_lang.production.builds.workers import LostBatch

ALL = sorted(SOUNDS)

ADA = "kind: character\nformat: 1\nname: ada\nposeset: facefx\nmodel: ../face.glb\n"


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    return Game(tmp_path, capsys)


@pytest.fixture(scope="session")
def first_builds(tmp_path_factory):
    """Folder of projects as their first builds left them."""
    return tmp_path_factory.mktemp("first_builds")


def as_built(game, kept):
    """Build a project once in a process, and copy what that left for all other tests."""
    if kept.exists():
        copytree(kept, game.folder, dirs_exist_ok=True)
    else:
        assert game.build().built == ALL
        copytree(game.folder, kept)
    return game


@pytest.fixture
def built(game, first_builds):
    return as_built(game, first_builds / "plain")


def test_a_build_makes_every_line_and_the_next_none(game):
    first = game.build()
    assert first.code == 0
    assert first.built == sorted(game.takes()) == ALL
    again = game.build()
    assert (again.code, again.built, again.end["current"]) == (0, [], len(ALL))


@pytest.fixture
def stale(built, monkeypatch):  # noqa: ARG001 the current folder
    """Return the planned lines of a project in which every need has changed."""
    monkeypatch.setattr(needs.PairNeeds, "current", lambda *_: bytes(8))
    project = ProjectBuild.open()
    with Records.open(project.folder) as known:
        return project.plan(known).stale


def test_stale_lines_share_the_words_of_their_reasons(stale):
    reasons = [one for step in stale for one in step.reasons]
    assert sorted(step.line.name for step in stale) == ALL
    assert len({id(one) for one in reasons}) == len({*reasons}) < len(reasons)


def test_a_stale_line_keeps_text_alone_beside_its_reasons(stale):
    assert stale
    for step in stale:
        assert step.record is None
        assert type(step.line.timings) is str
        assert {*map(type, step.reasons)} == {str}


def test_an_edited_bigram_remakes_the_lines_that_contain_it(built):
    before = built.takes()
    built.bank(0.5)
    assert built.build("--dry-run").stale == {"low": ["the bigram l-ow changed"]}
    assert built.build().built == ["low"]
    after = built.takes()
    assert [name for name in ALL if before[name] != after[name]] == ["low"]
    built.bank(0.6)
    assert built.build().built == ["low"]


def test_a_trigram_remakes_the_lines_that_contain_it(game):
    game.say("apart", "HH OW _ OW M")  # the same bigrams, but not in a row
    game.script([*SOUNDS, "apart"])
    game.build()
    before, path = game.takes(), "posesets/facefx/banks/common.yaml"
    for level in (0.8, 0.9):
        curves = f"{{FV: [[0, 0], [0.3, {level}], [0.6, {level}], [1, 0]]}}"
        drawn = f"trigrams:\n  h-ow-bmp: {{curves: {curves}}}\n"
        game.write(path, f"kind: bank\nformat: 1\nname: common\nposeset: facefx\n{drawn}")
        assert game.build("--dry-run").stale == {"home": ["the trigram h-ow-bmp changed"]}
        assert game.build().built == ["home"]
        assert [name for name, take in game.takes().items() if take != before[name]] == ["home"]
    (game.folder / path).unlink()
    assert game.build().built == ["home"]
    assert game.takes() == before


def test_a_bank_that_says_what_the_draft_says_remakes_nothing(built, capsys):
    assert main(["bank", "draft", "-l", "english", "-c", "facefx", "--write", "bmp-f"]) == 0
    capsys.readouterr()
    assert built.build("--dry-run").stale == {}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda game: game.say("map", "M AA P"), "its timings changed"),
        (
            lambda game: game.write(
                "script.csv", "id,text\nlow,low\nmap,maps\nmail,mail\nhome,home\n"
            ),
            "its text changed",
        ),
        (lambda game: (game.folder / "takes/map.csv").unlink(), "takes/map.csv is missing"),
    ],
)
def test_a_changed_line_is_made_again_by_itself(built, change, reason):
    change(built)
    assert built.build("--dry-run").stale == {"map": [reason]}
    assert built.build().built == ["map"]
    assert built.build().built == []


def test_a_moved_project_is_as_it_was(built, monkeypatch):
    moved = built.folder.with_name("moved")
    built.folder.rename(moved)
    monkeypatch.chdir(moved)
    assert built.build("--dry-run").stale == {}


@pytest.fixture
def paged(game, first_builds):
    """A project whose lines have pages, and a bank with a bigram of its own."""
    stated = (game.folder / "lipsync.yaml").read_text()
    game.write("lipsync.yaml", stated.replace("{id}.csv", "{id}.html"))
    game.bank(0.5)
    return as_built(game, first_builds / "paged")


def test_a_new_bigram_remakes_only_the_pages_that_show_it(paged):
    bank = next(paged.folder.glob("posesets/*/banks/*.yaml"))
    with bank.open("a") as more:
        more.write("  ey-l:\n    curves: {open: [[0, 0], [0.5, 0.3], [1, 0]]}\n")
    reasons = ["the bigram ey-l changed", "the source of the bigram ey-l changed"]
    assert paged.build("--dry-run").stale == {"mail": reasons}
    assert paged.build().built == ["mail"]
    pages = {path.name: path.read_bytes() for path in (paged.folder / "takes").iterdir()}
    assert b"common.yaml:8" in pages["mail.html"]
    assert paged.build("--force").built == ALL
    assert {path.name: path.read_bytes() for path in (paged.folder / "takes").iterdir()} == pages


def test_a_page_is_made_again_where_its_bigram_has_moved(paged):
    bank = next(paged.folder.glob("posesets/*/banks/*.yaml"))
    bank.write_text("# drawn by hand\n" + bank.read_text())
    reason = "the source of the bigram l-ow changed"
    assert paged.build("--dry-run").stale == {"low": [reason]}


def test_a_moved_project_has_the_same_pages(paged, monkeypatch):
    moved = paged.folder.with_name("moved_pages")
    paged.folder.rename(moved)
    monkeypatch.chdir(moved)
    assert paged.build("--dry-run").stale == {}


def test_a_worker_that_begins_its_build_again_is_told_so(game, monkeypatch):
    monkeypatch.setattr(build_run, "parent_process", lambda: "the build")
    monkeypatch.setattr(build_run, "claim", lambda _: None)
    assert "if __name__ == '__main__'" in game.build().err


def test_a_touched_file_changes_nothing(built):
    os.utime(built.folder / "vo/map.json", (1, 1))
    os.utime(built.folder / "takes/low.csv", (1, 1))
    assert built.build("--dry-run").stale == {}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("fps: 30", "fps: 25"),
        ("fps: 30", "fps: 30\nmotion: {speed_limit: 7}"),
        ("fps: 30", "fps: 30\noffset: 0.5"),
    ],
)
def test_changed_settings_remake_everything(built, old, new):
    built.write("lipsync.yaml", (built.folder / "lipsync.yaml").read_text().replace(old, new))
    assert built.build("--dry-run").stale == {
        name: ["the frame rate, offset, motion, limits or `glb` changed"] for name in ALL
    }


@needs_plug_ins
def test_every_sound_begins_at_the_projects_offset(game):
    stated = (game.folder / "lipsync.yaml").read_text().replace("takes/{id}.csv", "takes/{id}.tres")
    game.write("lipsync.yaml", stated + "offset: 0.75\n")
    assert game.build().built == ALL
    for name in ALL:
        text = (game.folder / f"takes/{name}.tres").read_text(encoding="utf-8")
        assert "metadata/audio_start = 0.75\n" in text


def test_another_version_of_the_program_remakes_everything(built, monkeypatch):
    monkeypatch.setattr(needs, "__version__", "99")
    assert built.build("--dry-run").stale == {
        name: ["the program's version changed"] for name in ALL
    }


def test_a_file_edited_by_hand_is_kept_and_named(built):
    edited = built.folder / "takes/map.csv"
    edited.write_text("mine")
    built.say("map", "M AA P")
    told = built.build()
    assert (told.built, told.end["kept"], edited.read_text()) == ([], ["takes/map.csv"], "mine")
    assert built.build("--overwrite").built == ["map"]
    assert edited.read_bytes().startswith(b"time")
    assert built.build().end["kept"] == []


def test_a_file_of_somebody_else_is_kept_and_an_equal_one_is_adopted(game):
    game.build()
    takes = game.takes()
    for path in (game.folder / ".lipsync_lang").iterdir():
        path.unlink()
    (game.folder / "takes/map.csv").write_text("mine")
    told = game.build()
    assert told.end["kept"] == ["takes/map.csv"]
    assert game.takes() == {**takes, "map": b"mine"}
    again = game.build()
    assert (again.built, again.end["kept"]) == ([], ["takes/map.csv"])


def test_a_line_that_fails_is_named_and_the_others_are_built(game):
    game.say("map", "M XYZ P")
    told = game.build()
    assert told.code == 1
    assert told.built == ["home", "low", "mail"]
    (failed,) = (e for e in told.events if e.get("outcome") == "failed")
    assert failed["name"] == "map"
    assert "script.csv:3" in failed["message"]
    assert "'XYZ'" in failed["message"]
    assert not (game.folder / "takes/map.csv").exists()
    game.say("map", "M AE P")
    assert game.build().built == ["map"]


def test_a_line_that_fails_again_keeps_the_output_of_before(built):
    before = built.takes()
    built.say("map", "M XYZ P")
    assert built.build().code == 1
    assert built.takes() == before
    built.say("map", "M AE P")
    assert built.build().code == 0
    assert built.takes() == before


def test_a_limit_of_the_project_fails_the_build_and_one_of_the_face_is_told(game):
    told = game.build()
    assert (told.code, told.end["over_limits"], told.end["doubted"]) == (0, 0, 3)
    project = (game.folder / "lipsync.yaml").read_text()
    game.write("lipsync.yaml", project + "limits: {closure_late: 0.01}\n")
    told = game.build()
    assert (told.code, told.end["over_limits"]) == (1, 2)
    assert game.build().code == 1, "a limit is passed until the line is mended"
    game.write("lipsync.yaml", project + "limits: {closure_late: 0.1}\n")
    assert game.build().code == 0


@pytest.mark.parametrize("limits", ["", "limits: {closure_late: 0.01}\n"])
def test_standing_lines_count_as_in_a_report(game, limits):
    game.write("lipsync.yaml", (game.folder / "lipsync.yaml").read_text() + limits)
    game.write("vo/home.json", "{")
    counts = ("lines", "failed", "over_limits", "doubted")
    fresh = game.build()
    standing = game.build()
    reported = game.build("--report", "build.json")
    assert fresh.end["failed"] == 1
    assert fresh.end["over_limits"] + fresh.end["doubted"] > 0
    for told in (standing, reported):
        assert told.code == fresh.code
        assert [told.end[name] for name in counts] == [fresh.end[name] for name in counts]


def test_an_edit_of_the_same_length_is_one(built):
    edited = built.folder / "takes/map.csv"
    content = edited.read_bytes()
    changed = content.replace(b"0.0", b"0.1", 1)
    assert len(changed) == len(content)
    edited.write_bytes(changed)
    built.say("map", "M AA P")
    assert built.build().end["kept"] == ["takes/map.csv"]


def test_a_file_replaced_with_equal_size_and_time_is_noticed(game):
    path = game.folder / "vo/low.json"
    os.utime(path, (1_000_000_000, 1_000_000_000))
    assert game.build().built == ALL
    path.write_text(path.read_text().replace("OW", "AW"))
    os.utime(path, (1_000_000_000, 1_000_000_000))
    assert game.build().built == ["low"]


def test_a_build_killed_between_record_and_rename_resumes(game, monkeypatch):
    class Killed(BaseException):
        pass

    def kill(*_):
        raise Killed

    monkeypatch.setattr(os, "replace", kill)
    with pytest.raises(Killed):
        game.build()
    game.capsys.readouterr()
    monkeypatch.undo()
    monkeypatch.chdir(game.folder)
    assert game.build().built == ALL
    assert game.build().built == []


def test_a_rename_that_never_came_is_made_again_and_not_taken_for_an_edit(built, monkeypatch):
    built.say("map", "M AA P")
    with monkeypatch.context() as context:
        context.setattr(os, "replace", lambda *_: None)
        assert built.build().built == ["map"]
    told = built.build()
    assert (told.built, told.end["kept"]) == (["map"], [])


def test_a_full_disk_ends_the_build_with_what_was_made(game, monkeypatch):
    real = making.created

    def full(temporary, target):
        if Path(target).stem == "map":
            raise OSError(28, "No space left on device")
        return real(temporary, target)

    monkeypatch.setattr(making, "created", full)
    told = game.build()
    assert told.code == 2
    assert "No space left" in told.err
    monkeypatch.undo()
    monkeypatch.chdir(game.folder)
    assert "map" in game.build().built


def test_what_killed_builds_and_workers_left_is_deleted(game, monkeypatch):
    before = left_behind(game.folder / "takes")
    real, during = making.created, []

    def created(temporary, target):
        if not during:
            during.append(left_behind(Path(target).parent, "y.csv"))
        return real(temporary, target)

    monkeypatch.setattr(making, "created", created)
    assert game.build().built == ALL
    assert not before.exists()
    assert not during[0].exists()


def test_models_outside_the_project_travel_to_the_workers_of_a_cluster(game, monkeypatch):
    (game.folder / "lipsync.yaml").write_text(PROJECT.replace('.csv"]', '.csv", "glb/{id}.glb"]'))
    models = []

    def cluster(work, batches, *, shared, folder, **_):
        for batch in batches:
            (pair,) = shared(batch).values()
            models.append(pair.performer.model)
            assert models[-1].is_relative_to(folder)
            assert models[-1].read_bytes() == ll.resolve("english", "facefx").model.read_bytes()
            yield work(batch, shared(batch))

    monkeypatch.setattr(build_run, "run_batches", cluster)
    assert game.build("--scheduler", "tcp://nobody:1").built == ALL
    assert not models[0].exists()
    monkeypatch.undo()
    monkeypatch.chdir(game.folder)
    assert game.build().built == []


def test_a_worker_that_outlives_a_build_makes_lost_folders_again(game):
    project = ProjectBuild.open()
    batch = LineBatch("english", ("facefx",), tuple(project.lines))
    maker, pairs = project.maker, {"facefx": project.pairs["english", "facefx"]}
    assert "failed" not in {made.record.verdict for made in maker(batch, pairs)}
    rmtree(game.folder / "takes")
    assert "failed" not in {made.record.verdict for made in maker(batch, pairs)}
    rmtree(game.folder / "takes")
    (game.folder / "takes").symlink_to(game.folder.parent)
    assert {made.record.verdict for made in maker(batch, pairs)} == {"failed"}


def test_a_worker_sends_packed_lines_and_the_build_records_them_as_they_came(game):
    project = ProjectBuild.open()
    batch = LineBatch("english", ("facefx",), tuple(project.lines))
    made = project.maker(batch, {"facefx": project.pairs["english", "facefx"]})
    sent = pickle.dumps(made)
    assert b"LineRecord" in sent
    # Thirty objects a line: to read them took the build a third of its time with two workers.
    assert not any(name in sent for name in (b"JudgedFigure", b"BuiltLine", b"PlannedLine"))
    assert game.build().built == ALL
    with Records.open(game.folder, write=False) as records:
        for key, known in (row for block in records.blocks() for row in block):
            (came,) = (one.record for one in made if one.key == key)
            added = {"inputs": "", "needs": b"", "outputs": {}, "result": came.result, "at": 0}
            assert known._replace(**added) == came
            assert as_json(records.result(key)) == came.result


def test_outputs_of_removed_lines_are_named_and_pruned_on_request(built):
    built.script([name for name in SOUNDS if name != "map"])
    assert built.build().end["gone"] == ["takes/map.csv"]
    assert sorted(built.takes()) == ALL
    assert built.build("--prune").code == 0
    assert sorted(built.takes()) == ["home", "low", "mail"]
    assert built.build().end["gone"] == []


def test_a_selection_builds_nothing_else_and_calls_nothing_gone(game):
    told = game.build("--only", "ma*")
    assert (told.built, told.end["gone"]) == (["mail", "map"], [])
    assert game.build().built == ["home", "low"]


def test_a_damaged_record_is_named(built):
    record = built.folder / ".lipsync_lang/build.sqlite"
    for path in record.parent.glob("build.sqlite*"):
        path.unlink()
    record.write_bytes(b"no record" * 100)
    told = built.build()
    assert told.code == 2
    assert str(record) in told.err
    assert "move it away" in told.err


@pytest.mark.parametrize("options", [(), ("--dry-run",)])
def test_a_damaged_record_is_closed_so_that_it_can_be_moved(built, monkeypatch, options):
    record = built.folder / ".lipsync_lang/build.sqlite"
    with closing(sqlite3.connect(record)) as base:
        base.execute("PRAGMA user_version = 99")
    opened, connect = [], sqlite3.connect
    monkeypatch.setattr(
        sqlite3, "connect", lambda *a, **k: opened.append(connect(*a, **k)) or opened[-1]
    )
    assert "another version" in built.build(*options).err
    assert opened
    for connection in opened:
        with pytest.raises(sqlite3.ProgrammingError, match="closed"):
            connection.execute("SELECT 1")


@pytest.mark.parametrize(
    ("column", "value"),
    swept([
        ("inputs", "[1]"),
        ("inputs", "{"),
        ("inputs", "[" * 10_000),
        ("inputs", '{"text": 1, "timings": 5}'),
        ("inputs", '{"timings": [{}]}'),
        ("inputs", '{"timings": []}'),
        ("contents", "3"),
        ("outputs", '{"takes/map.csv": [1]}'),
        ("outputs", '{"takes/map.csv": 1}'),
        ("outputs", '{"takes/map.csv": [[], {}, null]}'),
        ("result", "[]"),
        ("result", '{"outcome": "built"}'),
        ("result", '["built", "", 1, [1]]'),
        ("heading", "["),
        ("heading", "[[1]]"),
        ("figures", b"abc"),
        ("figures", "text"),
        ("confidence", "x"),
        ("needs", b"abc"),
        ("needs", "text"),
        ("needs", b"\xff" * 12),
        ("verdict", b"\xff"),
        ("at", "x"),
    ], 3),
)  # fmt: skip
def test_a_record_is_not_believed(built, column, value):
    tamper(built, f"UPDATE line SET {column} = ? WHERE name = 'map'", value)  # noqa: S608 our own
    os.utime(built.folder / "vo/map.json", (1, 1))
    takes = built.takes()
    told = built.build("--report", "report.html")
    assert told.code in {0, 2}
    assert told.code == 0 or "move it away" in told.err
    assert built.takes() == takes


def tamper(game, statement, value):
    """Change the record of a project as another program may."""
    with closing(sqlite3.connect(game.folder / ".lipsync_lang/build.sqlite")) as base:
        base.execute(statement, (value,))
        base.commit()


@pytest.mark.parametrize("name", ["bigram", "bigram l", "label", "word", "face x", "nothing", ""])
def test_a_need_of_another_form_makes_its_lines_again(built, name):
    tamper(built, "UPDATE need SET name = ? WHERE name = 'bigram l ow'", name)
    assert built.build().built == ["low"]


@pytest.mark.parametrize("link", [False, True])
def test_pruning_deletes_nothing_outside_the_project(built, link):
    victim = built.folder.parent / f"{built.folder.name}-precious.csv"
    path = f"../{victim.name}"
    if link:
        (built.folder / "up").symlink_to(built.folder.parent)
        path = f"up/{victim.name}"
    precious = (built.folder / "takes/map.csv").read_bytes()
    victim.write_bytes(precious)
    tamper(built, "UPDATE line SET outputs = replace(outputs, 'takes/map.csv', ?)", path)
    built.script(["low"])
    assert sorted(built.build("--prune").end["deleted"]) == ["takes/home.csv", "takes/mail.csv"]
    assert victim.read_bytes() == precious


def test_a_report_of_an_unchanged_build_reads_the_worst_lines_alone(game, monkeypatch):
    game.build()
    read = []
    real = build_run.restored
    monkeypatch.setattr(
        build_run, "restored", lambda line, *rest: read.append(line.name) or real(line, *rest)
    )
    monkeypatch.setattr(BuildTally.__init__, "__defaults__", (2,))
    told = game.build("--report", "r.html")
    assert (told.code, told.built, len(read)) == (0, [], 2)
    assert sorted(set(read)) != ALL
    game.build("--report", "r.html", "--report", "r.json")
    assert sorted(read[2:6]) == ALL, "a form that names each line reads all"


def test_what_a_writer_remarks_on_a_model_is_said_once(game, capsys):
    glb(game.folder / "face.glb", "open", "lipRound", "wide")
    game.write("characters/ada.yaml", ADA)
    project = PROJECT.replace("facefx", "ada").replace(".csv", ".glb")
    game.write("lipsync.yaml", project.replace("script.glb", "script.csv"))
    assert main(["build"]) == 0
    told = capsys.readouterr().err
    assert told.count("face.glb has nothing for ") == told.count(" has nothing for ") == 1
    assert "nothing for W, ShCh, PBM" in told
    remarks = game.build("--force").end["remarks"]
    assert [" has nothing for " in remark for remark in remarks] == [False, True]
    assert all(remark in told for remark in remarks)
    assert game.build().end["remarks"] == []


def test_words_that_a_recording_lacks_are_told_by_each_build(game, monkeypatch, capsys):
    timed = making.schedules

    def lacking(folder, lines, *more):
        for line, one in zip(lines, timed(folder, lines, *more), strict=True):
            yield replace(one, left_out=("big",) if line.name == "map" else ())

    monkeypatch.setattr(making, "schedules", lacking)
    first, again = game.build(), game.build("--report", "r.json")
    assert (first.end["lacking"], again.end["lacking"], again.built) == (1, 1, [])
    assert "'big'" in first.end["remarks"][0]
    assert main(["build"]) == 0
    assert "1 line with words left out" in capsys.readouterr().err


def test_lines_share_a_face(game):
    project = PROJECT.replace("takes/{id}.csv", "takes/{id}.glb")
    game.write("lipsync.yaml", project)
    told = game.build()
    assert told.built == ALL, [e.get("message") for e in told.events]
    whole = {path.stem: path for path in (game.folder / "takes").glob("*.glb")}
    weights = {name: read_animation(path).values for name, path in whole.items()}
    sizes = {name: path.stat().st_size for name, path in whole.items()}
    game.write("lipsync.yaml", project + "glb: {face: once}\n")
    assert game.build("--dry-run").stale["low"] == [
        "the frame rate, offset, motion, limits or `glb` changed"
    ]
    assert game.build().built == ALL
    (face,) = (game.folder / "takes").glob("facefx-*.face.bin")
    for name, path in whole.items():
        assert path.stat().st_size <= sizes[name] - face.stat().st_size + 200
        np.testing.assert_array_equal(read_animation(path).values, weights[name])
    content = face.read_bytes()
    face.unlink()
    assert (game.build().built, face.read_bytes()) == ([], content)


def test_an_archive_shares_no_face(game):
    project = PROJECT.replace("takes/{id}.csv", "takes/all.zip/{id}.glb")
    game.write("lipsync.yaml", project + "glb: {face: once}\n")
    told = game.build()
    assert told.code == 2
    assert "P405 cannot be made on facefx: an archive cannot share a face" in told.err


@pytest.mark.parametrize(("lines", "processes"), [(199, []), (200, [2])])
def test_processes_start_only_for_work_that_is_worth_them(game, monkeypatch, lines, processes):
    asked = []

    def run(jobs, count):
        asked.append(count)
        return (job.run() for job in jobs)

    monkeypatch.setattr(workers, "run_in_processes", run)
    game.script(game.say(f"line{number}", "L OW") or f"line{number}" for number in range(lines))
    told = game.build("--workers", "2")
    assert (told.code, len(told.built)) == (0, lines)
    assert asked == processes


def test_lines_whose_workers_died_fail_and_are_made_by_the_next_build(game, monkeypatch):
    def lose(work, batches, *, shared, **_):
        for batch in batches:
            if any(line.name == "map" for line in batch.lines):
                yield LostBatch(batch, "its worker process died")
            else:
                yield work(batch, shared(batch))

    with monkeypatch.context() as context:
        context.setattr(build_run, "run_batches", lose)
        told = game.build("--workers", "2")
    assert told.code == 1
    assert "map" not in told.built
    messages = [e["message"] for e in told.events if e.get("outcome") == "failed"]
    assert "script.csv:3: its worker process died" in messages
    again = game.build()
    assert again.code == 0
    assert sorted({*told.built, *again.built}) == sorted(game.takes()) == ALL


@pytest.mark.parametrize(
    ("place", "code", "words"),
    [
        (".lipsync_lang", 2, "build.lock: cannot be written: File exists; copy the"),
        ("takes", 1, "script.csv:2: takes: File exists"),
        ("build", 2, "build: cannot be written: File exists; name another place"),
    ],
)
def test_a_file_in_the_place_of_a_folder_is_named_and_kept(game, capsys, place, code, words):
    game.write(place, "mine")
    assert main(["build", "--report", "build/report.html"]) == code
    assert words in capsys.readouterr().err
    assert (game.folder / place).read_text("utf-8") == "mine"
    assert not list(game.folder.rglob("*.lipsync-tmp"))


def test_a_fault_of_all_lines_does_not_fill_the_screen(game, capsys, monkeypatch):
    monkeypatch.setattr(build_command, "SHOWN_FAILURES", 2)
    for name in ALL:
        game.say(name, "XYZ")
    assert main(["build"]) == 1
    told = capsys.readouterr().err.splitlines()
    assert sum(line.startswith("script.csv:") for line in told) == 2
    assert told.count("more lines fail; a report or --json names them all") == 1
    assert "4 failed" in told[-1]


def test_a_folder_in_the_place_of_an_output_fails_its_line_alone(game):
    (game.folder / "takes/map.csv").mkdir(parents=True)
    told = game.build()
    assert (told.code, told.built) == (1, ["home", "low", "mail"])
    (failed,) = (e for e in told.events if e.get("outcome") == "failed")
    assert failed["message"] == "script.csv:3: takes/map.csv: Is a directory"


def test_a_dry_run_writes_nothing(game):
    before = sorted(game.folder.rglob("*"))
    assert sorted(game.build("--dry-run").stale) == ALL
    assert sorted(game.folder.rglob("*")) == before


def test_a_need_is_stored_once(built):
    with Records.open(built.folder, write=False) as known:
        held = {key[2]: one.needs for block in known.blocks() for key, one in block}
    assert set(held) == set(ALL)
    used = {int(n) for one in held.values() for n in np.frombuffer(one, NEED)["number"]}
    assert used == set(known.names)


@pytest.mark.parametrize("rows", [1, 3])
def test_a_record_is_compared_in_parts_of_any_size(built, monkeypatch, rows):
    monkeypatch.setattr(records, "ROWS", rows)
    assert built.build().built == []
    built.bank(0.5)
    built.script(["map", "low", "home"])
    assert built.build("--dry-run").stale == {"low": ["the bigram l-ow changed"]}
    assert built.build().built == ["low"]


# Archives


@pytest.fixture
def archived(game, first_builds):
    stated = (game.folder / "lipsync.yaml").read_text("utf-8")
    game.write("lipsync.yaml", stated.replace("takes/{id}.csv", "takes/{character}.zip/{id}.csv"))
    return as_built(game, first_builds / "archived")


def packed(game):
    """Return the content of the archive, the only file, by the ids of its lines."""
    (file,) = (path for path in (game.folder / "takes").rglob("*") if path.is_file())
    with ZipFile(file) as archive:
        return {name.removesuffix(".csv"): archive.read(name) for name in archive.namelist()}


def repack(game, **changed):
    """Write other members into the archive."""
    rewrite(
        game.folder / "takes/facefx.zip",
        {f"{name}.csv": content for name, content in changed.items() if content},
        [f"{name}.csv" for name, content in changed.items() if not content],
    )


def test_the_lines_of_a_character_fill_one_archive(archived):
    assert sorted(packed(archived)) == ALL
    assert archived.build().built == []
    before = packed(archived)
    archived.bank(0.5)
    assert archived.build().built == ["low"]
    after = packed(archived)
    assert [name for name in ALL if before[name] != after[name]] == ["low"]


def test_members_are_missing_kept_and_pruned_as_files_are(archived):
    repack(archived, map=b"", mail=b"by hand")
    dry = archived.build("--dry-run")
    assert dry.stale == {"map": ["takes/facefx.zip/map.csv is missing"]}
    assert archived.build().built == ["map"]
    assert packed(archived)["mail"] == b"by hand"
    archived.script(["low"])
    archived.build("--prune")
    assert sorted(packed(archived)) == ["low", "mail"]


def test_a_killed_build_of_an_archive_resumes(game, monkeypatch):
    stated = (game.folder / "lipsync.yaml").read_text("utf-8")
    game.write("lipsync.yaml", stated.replace("takes/{id}.csv", "takes/all.zip/{id}.csv"))

    def killed(*_):
        raise SystemExit

    monkeypatch.setattr(keeping, "rewrite", killed)
    with pytest.raises(SystemExit):
        game.build()
    monkeypatch.undo()
    monkeypatch.chdir(game.folder)
    game.capsys.readouterr()
    assert not (game.folder / "takes/all.zip").exists()
    assert game.build().built == ALL
    assert sorted(packed(game)) == ALL


def test_a_damaged_archive_is_named_and_kept(archived):
    (archived.folder / "takes/facefx.zip").write_bytes(b"PK no archive")
    told = archived.build()
    assert told.code != 0
    assert "takes/facefx.zip: is a damaged archive" in told.err
    assert (archived.folder / "takes/facefx.zip").read_bytes() == b"PK no archive"


def test_a_style_that_moves_in_its_file_is_no_change_of_the_face():
    performer = ll.resolve("english", "facefx")

    def face(**changed):
        drafts = {n: one | changed for n, one in performer.compiled.style_drafts.items()}
        other = replace(performer, compiled=replace(performer.compiled, style_drafts=drafts))
        return needs.PairNeeds(other, needs.BuildSettings(30, {})).current("face")

    assert performer.compiled.style_drafts
    assert face(place="posesets/facefx/poseset.yaml:99:1") == face()
    assert face(scale=[1.0] * len(performer.poses)) != face()


def test_a_worker_knows_a_model_whose_copy_an_interrupted_build_deleted(tmp_path):
    performer = ll.resolve("english", "facefx")
    copy = tmp_path / "face.glb"
    copy.write_bytes(b"a face")
    compiled = replace(performer.compiled, model=str(copy))
    one = needs.PairNeeds(replace(performer, compiled=compiled), needs.BuildSettings(30, {}))
    sent = pickle.dumps(one)
    copy.unlink()
    there = pickle.loads(sent)  # noqa: S301 our own
    assert there.current("model") == one.current("model") != needs.digest(None)


def test_a_build_keeps_no_line_that_its_record_has(game, monkeypatch):
    read = []
    restored = build_run.restored

    def counted(line, *rest):
        read.append(line.name)
        return restored(line, *rest)

    monkeypatch.setattr(build_run, "restored", counted)
    game.build("--report", "report.html")
    assert set(read) == set(SOUNDS)  # they are the worst lines, and were all made just now
