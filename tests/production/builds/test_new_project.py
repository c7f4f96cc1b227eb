"""Projects drafted from recordings and a table: ids by content, folders as placeholders."""

from hashlib import md5
from pathlib import Path

import pytest
from lanes import needs_plug_ins

from lipsync_lang.packs.project import load_project
from lipsync_lang.production.builds.script import read_script

TABLE = """\
line,key,english,deutsch,de
1,intro_1,Hello.,x,Hallo.
2,intro_2,How are you?,y,Wie geht es?
3,outro_1,Goodbye.,z,Tschüss.
"""


@pytest.fixture
def game(tmp_path, monkeypatch):
    """An empty folder with a table of three lines."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.csv").write_text(TABLE, "utf-8")
    return tmp_path


def record(game, *names):
    for name in names:
        (game / name).parent.mkdir(parents=True, exist_ok=True)
        (game / name).touch()


def new(cli, *more):
    return cli("new", "--recordings", "vo", "--from", "script.csv", *more)


def stated(game):
    return (game / "lipsync.yaml").read_text("utf-8")


def test_the_column_of_ids_is_the_one_that_names_the_recordings(cli, game):
    record(game, "vo/intro_1.wav", "vo/intro_2.wav", "vo/other.wav")
    ended = new(cli, "-l", "english")
    assert ended.code == 0
    assert ended.err.splitlines() == [
        "wrote lipsync.yaml",
        "2 of 3 recordings have a line",
        "1 recording without a line: vo/other",
        "1 line without a recording: outro_1",
        "3 lines to make, in 1 language on 1 character; next, run: lipsync-lang build",
    ]
    text = stated(game)
    assert "columns: {id: key}" in text
    assert "languages: [english]" in text
    assert 'audio: "vo/{id}.wav"' in text
    assert 'outputs: "takes/{character}/{id}.csv"' in text


def test_folders_of_languages_and_speakers_become_placeholders(cli, game):
    (game / "script.csv").write_text(
        "id,who,german,en\na_1,Ann,Hallo.,Hello.\nb_1,Bob,Ja.,Yes.\n", "utf-8"
    )
    record(
        game, *(f"vo/{tag}/{path}.WAV" for tag in ("en", "de") for path in ("Ann/a_1", "Bob/b_1"))
    )
    ended = new(cli)
    assert ended.code == 0, ended.err
    assert "4 of 4 recordings have a line" in ended.err
    text = stated(game)
    assert 'audio: "vo/{language}/{speaker}/{id}.WAV"' in text
    assert "languages: {german: de, english: en}" in text
    assert "speaker: who" in text
    assert 'outputs: "takes/{language}/{character}/{id}.csv"' in text
    assert '#   "Ann": ...' in text


@pytest.mark.parametrize(
    ("head", "more", "stated_lines"),
    [
        (
            "key,speaker,text",
            (),
            ["columns: {id: key, text: text, speaker: speaker}", "languages: [english]"],
        ),
        ("key,speaker,text", ("-l", "fi"), ["languages: [finnish]"]),
        (
            "key,speaker,line in it",
            (),
            ["columns: {id: key, text: line in it, speaker: speaker}"],
        ),
        ("key,de,en", (), ["columns: {id: key}", "languages: {german: de, english: en}"]),
    ],
)
def test_a_table_alone_makes_a_project(cli, game, head, more, stated_lines):
    (game / "script.csv").write_text(f"{head}\na,Hello.,Hello.\nb,Bye.,Bye.\n", "utf-8")
    ended = cli("new", "--from", "script.csv", *more)
    lines = 4 if "de" in head else 2
    assert (ended.code, ended.err.splitlines()[0]) == (0, "wrote lipsync.yaml")
    assert f"{lines} lines to make" in ended.err
    assert set(stated_lines) <= set(stated(game).splitlines())
    assert "# audio: " in stated(game)


@pytest.mark.parametrize(
    ("head", "languages"),
    [
        ("Key,Id,English(en),French(fr),German(de)", "[english, french, german]"),
        ("id,Character,Line EN,Line FR,Direction", "[english, french]"),
        ("keys,en,fr", "{english: en, french: fr}"),
        ("id,Notes,English text,voice_id,line no", "[english]"),
        ("id,German translation,French VO,Polish status", "[german, french]"),
    ],
)
def test_names_of_languages_inside_headers_are_read(cli, game, head, languages):
    cells = [f"words of {name}, " * 3 for name in head.split(",")[1:]]
    rows = [",".join([name, *(f'"{name}, {one}"' for one in cells)]) for name in "ab"]
    (game / "script.csv").write_text("\n".join([head, *rows, ""]), "utf-8")
    ended = cli("new", "--from", "script.csv")
    assert ended.code == 0, ended.err
    assert f"languages: {languages}" in stated(game).splitlines()
    assert "guess" not in ended.err


def test_a_language_without_a_pack_is_named_by_its_code(cli, game):
    (game / "script.csv").write_text("id,text\na,mama\nb,papa\n")
    ended = cli("new", "--from", "script.csv", "-l", "ipa:lg")
    assert ended.code == 0, ended.err
    assert 'languages: ["ipa:lg"]' in stated(game).splitlines()
    (game / "lipsync.yaml").unlink()
    assert "unknown language 'ipa:'" in cli("new", "--from", "script.csv", "-l", "ipa:").err


def test_a_doubtful_text_is_asked_for_and_a_guess_is_told(cli, game):
    (game / "script.csv").write_text("id,Cue,Direction\na,Hello you.,whispers\nb,Bye.,sadly\n")
    ended = cli("new", "--from", "script.csv")
    assert ended.code == 2
    assert "which column is the text, 'Cue' or 'Direction'? Say --column Cue" in ended.err
    assert not (game / "lipsync.yaml").exists()
    assert cli("new", "--from", "script.csv", "--column", "cue").code == 0
    assert "columns: {id: id, text: Cue}" in stated(game)
    (game / "lipsync.yaml").unlink()
    (game / "script.csv").write_text("id,Cue,Tone\na,Hello to all of you.,low\nb,Bye now.,low\n")
    ended = cli("new", "--from", "script.csv")
    assert "the text is a guess: 'Cue', the column with the most letters" in ended.err
    assert "columns: {id: id, text: Cue}" in stated(game)


def test_the_encoding_of_a_script_is_stated(cli, game):
    (game / "script.csv").write_bytes("id,text\na,Café.\n".encode("cp1252"))
    ended = cli("new", "--from", "script.csv")
    assert ended.code == 2
    assert "name its encoding (--encoding cp1252)" in ended.err
    assert cli("new", "--from", "script.csv", "--encoding", "cp1252").code == 0
    assert "encoding: cp1252" in stated(game).splitlines()


def test_a_title_above_the_names_of_columns_is_left_out(cli, game):
    (game / "script.csv").write_text("The game,,\n,,\nid,speaker,text\na,Ann,Hello.\n")
    ended = cli("new", "--from", "script.csv")
    assert ended.code == 0, ended.err
    assert "columns: {id: id, text: text, speaker: speaker}" in stated(game)
    assert "1 line to make" in ended.err


def test_a_table_alone_needs_a_column_of_ids(cli, game):
    (game / "script.csv").write_text("cue,text\na,Hello.\n", "utf-8")
    ended = cli("new", "--from", "script.csv")
    assert ended.code == 2
    assert "script.csv:1: no column is named like one of ids" in ended.err
    assert ended.err.endswith("Its columns: cue, text\n")


def test_names_may_have_more_around_the_id(cli, game):
    record(game, *(f"vo/EN_{name}_final.wav" for name in ("intro_1", "intro_2", "outro_1")))
    ended = new(cli, "-l", "en")
    assert "3 of 3 recordings have a line" in ended.err
    assert 'audio: "vo/en_{id}_final.wav"' in stated(game)


def test_a_text_column_of_no_language_is_stated(cli, game):
    (game / "script.csv").write_text("cue,words of it,id\nc1,Hello.,1\nc2,Bye now.,2\n")
    record(game, "vo/c1.wav", "vo/c2.wav")
    ended = new(cli, "-l", "english")
    assert ended.code == 0, ended.err
    assert "columns: {id: cue, text: words of it}" in stated(game)


def test_what_has_nothing_in_common_is_told_with_what_there_is(cli, game):
    record(game, "vo/q9.wav")
    ended = new(cli, "-l", "english")
    assert ended.code == 2
    assert "no column names the 1 recordings in vo, such as q9" in ended.err
    assert "key: intro_1, intro_2" in ended.err
    assert not (game / "lipsync.yaml").exists()


RENPY = """label start:
    e "Hello there, world."
    "Bo Li" "Hi."
"""


@needs_plug_ins
@pytest.mark.parametrize("script", ["game", "game/script.rpy"])
def test_a_script_that_names_its_lines_makes_a_project_without_columns(folder, cli, script):
    (folder / "game").mkdir()
    (folder / "game" / "script.rpy").write_text(RENPY, "utf-8")
    (folder / "game" / "more.rpy").write_text(RENPY.replace("start", "other"), "utf-8")
    ended = cli("new", "--from", script)
    assert ended.code == 0, ended.err
    text = (folder / "lipsync.yaml").read_text("utf-8")
    assert f"lines: {script}\n" in text
    assert "columns" not in text
    assert "Bo Li" in text
    assert cli("validate").code == 0


GERMAN = """\
translate german start_{digest}:
    s "Hallo, wie geht es dir?"
translate german strings:
    old "Leave."
    new ""
"""


@needs_plug_ins
def test_a_folder_of_translations_is_a_language_of_its_own(folder, cli):
    said = 's "Hello, how are you?"'
    digest = md5(f"{said}\r\n".encode(), usedforsecurity=False).hexdigest()[:8]
    (folder / "game/tl/german").mkdir(parents=True)
    (folder / "game/script.rpy").write_text(f"label start:\n    {said}\n", "utf-8")
    translated = folder / "game/tl/german/script.rpy"
    translated.write_text(GERMAN.replace("{digest}", digest), "utf-8")
    assert cli("new", "--from", "game").code == 0
    assert "languages: [english, german]" in stated(folder)
    ended = cli("build", "-q")
    assert ended.code == 0, ended.err
    takes = sorted(path.relative_to(folder / "takes") for path in folder.rglob("takes/*/*/*.csv"))
    assert takes == [Path(name, f"facefx/start_{digest}.csv") for name in ("english", "german")]
    counted = cli("coverage", "-l", "german")
    assert counted.out.startswith("1 file, 1 line, 5 words")
    assert "script.rpy: left out 1 empty or untranslated line" in counted.err
    (folder / "lipsync.yaml").unlink()
    ended = cli("new", "--from", "game", "-l", "german")
    assert "languages: [german]" in stated(folder)
    assert "1 line to make" in ended.err
    assert "1 file in other languages left out: game/script.rpy" in cli("build").err


XLIFF = """<xliff version="1.2"><file source-language="en" target-language="de-DE"><body>
<trans-unit id="a"><source>Go.</source><target>Geh.</target></trans-unit>
<trans-unit id="b"><source>Stay.</source></trans-unit></body></file></xliff>
"""


@pytest.mark.parametrize(
    ("arguments", "told", "lines"),
    [
        ((), "a.xlf: the originals are the text in english\n2 lines", 2),
        (
            ("-l", "german"),
            "the translations are the text in german\na.xlf: left out 1 empty or untranslated",
            1,
        ),
        (("-l", "french"), "a.xlf: no text is in french; the text in de-DE is read\n", 1),
    ],
)
def test_the_side_of_a_bilingual_script_is_told(folder, cli, arguments, told, lines):
    (folder / "a.xlf").write_text(XLIFF, "utf-8")
    ended = cli("new", "--from", "a.xlf", *arguments)
    assert ended.code == 0, ended.err
    assert told in ended.err
    assert f"\n{lines} line" in ended.err


def test_a_project_states_where_its_table_begins(folder, cli):
    (folder / "a.csv").write_text("Maps,of,x\n7,8,9\nid,Said,Who\na,Hello.,Bo\n", "utf-8")
    ended = cli("new", "--from", "a.csv", "--header-row", "3", "--column", "Said")
    assert ended.code == 0, ended.err
    assert "1 line to make" in ended.err
    assert "header_row: 3" in (folder / "lipsync.yaml").read_text("utf-8")
    assert cli("validate").code == 0
    counted = cli("coverage")
    assert counted.out.startswith("1 file, 1 line, 1 word"), counted.out + counted.err
    assert "no number of a row" in cli("coverage", "--header-row", "0").err


def test_a_folder_without_a_script_is_refused(folder, cli):
    (folder / "game").mkdir()
    ended = cli("new", "--from", "game")
    assert ended.code == 2
    assert "game: has no script; name a folder with .csv" in ended.err


@pytest.mark.parametrize(
    "name",
    ["{lines}", "{language}", "{{id}}", "a } b {", "{}", "[x] *", "- 'a': #b", "{{{language"],
)
def test_names_of_files_may_have_signs_that_a_project_reads_otherwise(cli, game, name):
    try:
        record(game, f"vo {name}/intro_1.wav", f"vo {name}/intro_2.wav", f"vo {name}/outro_1.wav")
        (game / "script.csv").rename(game / f"{name}.csv")
    except OSError:
        pytest.skip("no file of this system has such a name")
    ended = cli("new", "--recordings", f"vo {name}", "--from", f"{name}.csv", "-l", "english")
    assert ended.code == 0
    lines = read_script(load_project(game / "lipsync.yaml"))
    assert [line.audio for line in lines] == [
        str(game / f"vo {name}" / f"{key}.wav") for key in ("intro_1", "intro_2", "outro_1")
    ]
    assert cli("coverage").code == 0


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (
            ("vo", "script.csv"),
            "the language of the recordings is unknown; state --language english",
        ),
        (("vo", "script.csv", "-l", "englsh"), "did you mean 'english'?"),
        (("vo", "script.csv", "-l", "en", "-c", "facfx"), "did you mean 'facefx'?"),
        (("none", "script.csv"), "none: no such folder"),
        (("empty", "script.csv"), "empty: contains no .wav"),
        (("vo", "none.csv"), "none.csv: no such file"),
        (("vo", "/etc/hosts"), "/etc/hosts: is outside of"),
        (("vo", "script.txt"), "script.txt: no line is named like a recording in vo"),
    ],
)
def test_what_cannot_be_told_is_asked_for(cli, game, arguments, told):
    record(game, "vo/intro_1.wav", "script.txt", "empty/a.txt")
    recordings, table, *more = arguments
    ended = cli("new", "--recordings", recordings, "--from", table, *more)
    assert ended.code == 2
    assert told in ended.err
    assert not (game / "lipsync.yaml").exists()


def test_a_project_is_never_overwritten(cli, game):
    record(game, "vo/intro_1.wav")
    (game / "lipsync.yaml").write_text("mine")
    assert "already exists" in new(cli, "-l", "en").err
    assert stated(game) == "mine"


def test_faults_of_the_script_are_told_at_once(cli, game):
    record(game, "vo/intro_1.wav")
    with (game / "script.csv").open("a") as out:
        out.write("4,a/b,Hello.,,\n")
    ended = new(cli, "-l", "en")
    assert ended.code == 1
    assert "script.csv:5: the id 'a/b' has a '/'" in ended.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((), "give the NAME of the new folder"),
        (("--recordings", "vo"), "--recordings FOLDER needs their script too: --from SCRIPT"),
        (("game", "--from", "script.csv"), "leave one of the two out"),
        (("game", "--recordings", "vo", "--from", "script.csv"), "leave one of the two out"),
        (("game", "-c", "crab", "-c", "arkit"), "a new folder has one character"),
    ],
)
def test_a_folder_and_recordings_are_two_ways_to_begin(cli, game, arguments, told):
    record(game, "vo/intro_1.wav")
    ended = cli("new", *arguments)
    assert (ended.code, ended.out) == (2, "")
    assert told in ended.err
    assert {path.name for path in game.iterdir()} == {"script.csv", "vo"}


def test_recordings_are_made_on_several_characters(cli, game):
    record(game, "vo/intro_1.wav")
    assert new(cli, "-l", "en", "-c", "crab", "-c", "arkit").code == 0
    assert 'cast: {"*": [crab, arkit]}' in stated(game)


def test_characters_of_a_folder_of_packs_are_known(cli, game):
    record(game, "vo/intro_1.wav", "packs/characters/bob.yaml")
    character = "kind: character\nformat: 1\nname: bob\nposeset: crab\n"
    (game / "packs/characters/bob.yaml").write_text(character)
    assert cli("new", "out", "-c", "bob").code == 2
    assert cli("new", "out", "-c", "bob", "--path", "packs").code == 0
    assert "character: bob" in (game / "out/lipsync.yaml").read_text("utf-8")
    ended = new(cli, "-l", "en", "-c", "bob", "--path", "packs")
    assert 'cast: {"*": bob}' in stated(game), ended.err
