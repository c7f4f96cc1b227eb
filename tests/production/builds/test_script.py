"""The script of a build: its lines, their files, and every fault of its tables."""

import json

import pytest
from lanes import needs_plug_ins

from lipsync_lang import LipsyncError
from lipsync_lang.base.files.names import MAX_NAME_BYTES, fault_of_name
from lipsync_lang.packs.project import load_project
from lipsync_lang.production.builds.script import read_script
from lipsync_lang.text.lines.line_readers import LineFile, is_timed

SCRIPT = """\
id,speaker,english,german
intro_1,anna,Hello.,Hallo.
intro_2,bob,How are you?,Wie geht es?
"""
PROJECT = {
    "lines": "script.csv",
    "languages": "[english, german]",
    "cast": '{anna: facefx, "*": crab}',
    "audio": '"vo/{language}/{id}.wav"',
    "outputs": '"takes/{language}/{character}/{id}.csv"',
}


@pytest.fixture
def game(tmp_path, monkeypatch):
    """A folder with a script and its project."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.csv").write_text(SCRIPT)
    return tmp_path


def planned(game, remarks=None, **changed):
    """Read the script of a project with some fields changed; None removes a field."""
    stated = {name: text for name, text in (PROJECT | changed).items() if text is not None}
    text = "kind: project\nformat: 1\n" + "".join(f"{n}: {t}\n" for n, t in stated.items())
    (game / "lipsync.yaml").write_text(text)
    project = load_project(game / "lipsync.yaml")
    return read_script(project, remark=None if remarks is None else remarks.append)


def refusal(game, **changed):
    with pytest.raises(LipsyncError) as told:
        planned(game, **changed)
    return str(told.value)


def put(game, *names, text="x"):
    for name in names:
        (game / name).parent.mkdir(parents=True, exist_ok=True)
        (game / name).write_text(text, "utf-8")


# Lines


def test_ids_of_several_files_begin_with_the_name_of_the_file(game):
    put(game, "ui/menu.json", "ui/shop.json", text='{"greet": "Hello.", "only": "Bye."}')
    put(game, "ui/menu.json", text='{"greet": "Hi.", "maps": "{n, plural, one {x} other {y}}"}')
    put(game, "shop.arb", text='{"maps": "{n, plural, one {a} other {b}}"}')
    remarks = []
    lines = planned(
        game, remarks, lines="[ui, shop.arb]", languages="[english]", cast='{"*": crab}',
        audio=None, outputs='"{id}.json"',
    )  # fmt: skip
    assert {line.name: line.text for line in lines} == {
        "menu.greet": "Hi.",
        "menu.maps-one": "x",
        "menu.maps-other": "y",
        "ui.shop.greet": "Hello.",
        "only": "Bye.",
        "shop.maps-one": "a",
        "shop.maps-other": "b",
    }
    assert "share begin with the name of the file: menu.greet, menu.maps-one" in remarks[0]


def test_the_word_of_a_language_is_no_part_of_the_name_of_a_file(game):
    for word in ("english", "german"):
        put(game, f"a.{word}.json", f"b-{word}.json", f"{word}/b.json", text='{"x": "Oh."}')
    lines = planned(
        game, lines='["a.{language}.json", "b-{language}.json", "{language}"]', audio=None,
        outputs='"{language}/{id}.csv"', cast='{"*": crab}',
    )  # fmt: skip
    put(game, "a.json", "a.arb", text='{"x": "Oh."}')
    assert sorted({line.name for line in lines if line.language == "german"}) == [
        "a.x",
        "b.x",
        "german.b.x",
    ]
    alike = planned(
        game, lines="[a.json, a.arb]", languages="[english]", audio=None, outputs='"{id}.csv"',
        cast='{"*": crab}',
    )  # fmt: skip
    assert [line.name for line in alike] == ["a.json.x", "a.arb.x"]


def test_a_row_is_a_line_in_every_language_on_the_characters_of_its_speaker(game):
    lines = planned(game)
    assert [(one.key, one.text, one.speaker, one.place) for one in lines] == [
        (("english", "facefx", "intro_1"), "Hello.", "anna", "script.csv:2"),
        (("german", "facefx", "intro_1"), "Hallo.", "anna", "script.csv:2"),
        (("english", "crab", "intro_2"), "How are you?", "bob", "script.csv:3"),
        (("german", "crab", "intro_2"), "Wie geht es?", "bob", "script.csv:3"),
    ]
    assert lines[3].outputs == (("csv", "takes/german/crab/intro_2.csv"),)


def test_placeholders_have_the_values_of_the_project_and_its_list_is_not_spoken(game):
    put(
        game,
        "script.csv",
        text="id,english,german\na,NPC [who] <b>runs</b>,{who läuft\nb,[x],(x)\n",
    )
    remarks = []
    lines = planned(
        game, remarks, values="{who: Ada}", unspoken="NPC", audio=None, cast="{'*': crab}"
    )
    assert [one.text for one in lines] == ["Ada runs", "who läuft", "[x]", "(x)"]
    assert remarks == [
        "script.csv:2: column 1: '{' has no partner, so the text next to it is spoken"
    ]


def test_languages_and_characters_answer_to_their_other_names(game):
    lines = planned(game, languages="{en: E, de: D}", cast='{"*": [FaceFX, CRAB]}')
    assert {(one.language, one.character) for one in lines} == {
        (language, character)
        for language in ("english", "german")
        for character in ("facefx", "crab")
    }
    assert lines[0].outputs == (("csv", "takes/E/facefx/intro_1.csv"),)


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("key;who;EN;de-DE", None),
        ("key;who;Text (english);Text (german)", '{text: "Text ({language})"}'),
        ("ID of line;Rolle;en;de", '{id: "id of line", speaker: "2"}'),
    ],
)
def test_columns_are_found_or_stated(game, head, columns):
    put(game, "script.csv", text=f"{head}\na;anna;Hello.;Hallo.\n")
    lines = planned(game, columns=columns)
    assert [(one.name, one.speaker, one.text) for one in lines] == [
        ("a", "anna", "Hello."),
        ("a", "anna", "Hallo."),
    ]


def test_one_language_needs_no_column_of_its_name(game):
    put(game, "script.csv", text="id|text\na|{i}Well{/i}, *hello* [sighs]\n")
    [line] = planned(game, languages=None, language="english", cast=None, character="crab")
    assert (line.text, line.speaker) == ("Well, *hello*", "")


@needs_plug_ins
def test_a_file_for_each_language_holds_the_lines_of_that_language(game):
    put(game, "loc/en.po", text='msgctxt "a"\nmsgid "Hello."\nmsgstr "Hello."\n')
    put(game, "loc/de.po", text='msgctxt "a"\nmsgid "Hello."\nmsgstr "Hallo."\n')
    lines = planned(game, languages="[en, de]", lines='"loc/{language}.po"')
    assert [(one.language, one.name, one.text) for one in lines] == [
        ("english", "a", "Hello."),
        ("german", "a", "Hallo."),
    ]
    assert "has one language" in refusal(game, lines="loc/de.po")


def test_a_file_of_several_languages_holds_the_lines_of_each(game):
    unit = '<trans-unit id="{0}"><source>{1}</source><target>{2}</target></trans-unit>'
    units = unit.format("a", "Hello.", "Hallo.") + unit.format("b", "Go.", "Geh.")
    head = '<xliff><file source-language="en" target-language="de">'
    put(game, "game.xlf", text=f"{head}{units}</file></xliff>")
    stated = {"lines": "game.xlf", "cast": "{'*': crab}"}
    lines = planned(game, **stated)
    assert [(one.language, one.name, one.text) for one in lines] == [
        ("english", "a", "Hello."),
        ("german", "a", "Hallo."),
        ("english", "b", "Go."),
        ("german", "b", "Geh."),
    ]
    assert "has one language" in refusal(game, **stated, languages="[german, french]")


@needs_plug_ins
def test_comments_of_gettext_name_the_speaker_in_the_form_that_a_project_states(game):
    put(game, "de.po", text='#. [bob] sadly\nmsgctxt "a"\nmsgid "Hello."\nmsgstr "Hallo."\n')
    stated = {"lines": "de.po", "languages": "[german]"}
    lines = planned(game, columns='{speaker: "[{speaker}]"}', **stated)
    assert [one.speaker for one in lines] == ["bob"] * len(lines)
    assert {one.speaker for one in planned(game, columns=None, **stated)} == {""}


@needs_plug_ins
def test_names_of_lines_without_an_id_do_not_depend_on_their_order(game):
    entries = ['msgid "Yes"\nmsgstr "Ja"\n', 'msgid "No"\nmsgstr "Nein"\n']
    entries += ['msgctxt "x/y"\nmsgid "A"\nmsgstr "B"\n']
    names = []
    for order in (entries, entries[::-1]):
        put(game, "de.po", text="\n".join(order))
        lines = planned(game, lines="de.po", languages="[german]")
        names.append({one.text: one.name for one in lines})
    assert names[0] == names[1]
    assert len(set(names[0].values())) == 3
    assert not [name for name in names[0].values() if fault_of_name(name)]
    assert names[0]["Ja"].startswith("Yes-"), "named like the original, in every language"


# Files


def test_recordings_and_the_timings_beside_them_are_found(game):
    put(game, "vo/english/intro_1.WAV", "vo/german/intro_1.wav", "vo/german/other.wav")
    put(game, "vo/english/intro_1.TextGrid", "vo/german/intro_2.txt")
    put(game, "vo/german/intro_1.json", text='[{"label": "M", "start": 0, "end": 0.2}]')
    remarks = []
    lines = {(one.language, one.name): one for one in planned(game, remarks)}
    found = lines["english", "intro_1"]
    assert (found.audio, found.timings) == (
        str(game / "vo/english/intro_1.WAV"),
        str(game / "vo/english/intro_1.TextGrid"),
    )
    assert lines["german", "intro_1"].timings == str(game / "vo/german/intro_1.json")
    assert lines["german", "intro_2"].timings is None, "a transcript is no timings"
    assert remarks == [
        "english: 1 line without a recording, so a voice speaks: vo/english/intro_2.wav",
        "german: 1 line without a recording, so a voice speaks: vo/german/intro_2.wav",
        "1 recording without a line: vo/german/other.wav",
    ]


def test_long_timings_beside_a_recording_are_found(game):
    rows = [{"label": "AA1", "start": at / 10, "end": (at + 1) / 10} for at in range(200)]
    put(game, "vo/english/intro_1.json", text=json.dumps({"phonemes": rows}))
    assert planned(game)[0].timings == str(game / "vo/english/intro_1.json")


@pytest.mark.parametrize("text", ['{"phonemes": [{"label": "M"},]}', '[{"label": "M"'])
def test_damaged_timings_beside_a_recording_are_not_overlooked(game, text):
    put(game, "vo/english/intro_1.wav", "vo/english/intro_2.wav")
    put(game, "vo/english/intro_1.json", text=text)
    put(game, "vo/english/intro_2.json", text='{"take": 3}')
    put(game, "vo/english/intro_2.txt", text="[sobs] Well met.")
    lines = {one.name: one for one in planned(game) if one.language == "english"}
    assert lines["intro_1"].timings == str(game / "vo/english/intro_1.json"), "its reader says why"
    assert lines["intro_2"].timings is None, "notes of another program"


def test_timings_that_cannot_be_opened_are_not_overlooked(game, monkeypatch):
    put(game, "vo/english/intro_1.json", text='[{"label": "M", "start": 0, "end": 0.2}]')

    def refused(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(LineFile, "open", refused)
    lines = LineFile(game / "vo/english/intro_1.json", lambda _: None)
    assert not is_timed(lines)
    assert is_timed(lines, unreadable=True)


def test_a_folder_of_recordings_that_cannot_be_read_is_refused(game):
    put(game, "takes-of-bob", text="a file")
    with pytest.raises(LipsyncError, match=r"takes-of-bob: cannot be read: .*; correct its perm"):
        planned(game, audio='"takes-of-bob/{language}-{id}.wav"')
    assert planned(game, audio='"nowhere/{language}-{id}.wav"')[0].audio is None
    assert planned(game, audio=f'"{"x" * 300}/{{language}}-{{id}}.wav"')[0].audio is None


def test_outputs_beside_a_recording_are_not_its_timings(game):
    put(game, "vo/english/intro_1.json", text='[{"label": "M", "start": 0, "end": 0.2}]')
    beside = '"vo/{language}/{id}.json"'
    assert planned(game)[0].timings is not None
    assert planned(game, outputs=beside)[0].timings is None
    assert "is an input file" in refusal(game, outputs=beside, timings=beside)


def test_timings_may_have_a_place_of_their_own(game):
    put(game, "mfa/german/intro_2.TextGrid")
    remarks = []
    lines = planned(game, remarks, timings='"mfa/{language}/{id}.TextGrid"', audio=None)
    assert [one.timings is not None for one in lines] == [False, False, False, True]
    assert "german: 1 line without the stated timings: mfa/german/intro_1.TextGrid" in remarks


def test_lines_without_text_are_left_out_unless_they_have_files(game):
    put(game, "script.csv", text="id,english,german\na,,Hallo.\nb,Hello.,\n,,\n")
    put(game, "vo/german/b.wav")
    remarks = []
    lines = planned(game, remarks, cast=None, character="crab")
    assert [(one.language, one.name, one.text) for one in lines] == [
        ("german", "a", "Hallo."),
        ("english", "b", "Hello."),
        ("german", "b", ""),
    ]
    assert remarks[0] == "english: 1 line without text, left out: script.csv:2"


# Faults


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("a/b", "has a '/'"),
        ("a\\b", "has a '\\'"),
        ("..", "begins with a dot"),
        ("/etc/passwd", "has a '/'"),
        (".hidden", "begins with a dot"),
        ("a\x07b", "invisible character"),
        ("CON", "device on Windows"),
        ("com1.intro", "device on Windows"),
        ("a.", "ends in a space or a dot"),
        ("a:b", "has a ':'"),
        ("ä" * MAX_NAME_BYTES, "is longer than"),
    ],
)
def test_ids_name_files_on_every_system(game, name, fault):
    put(game, "script.csv", text=f"id,english,german\n{name},Hello.,Hallo.\n")
    assert refusal(game, cast=None, character="crab").startswith("script.csv:2: the id ")
    assert fault in fault_of_name(name)


@pytest.mark.parametrize(
    "name", ["intro_1", "a", "ü", "第一", "con_1", "console", "a.b", "x" * 200]
)
def test_ordinary_ids_are_sound(name):
    assert not fault_of_name(name)


@pytest.mark.parametrize(
    ("rows", "fault"),
    [
        (["a,A", "b,B", "a,C"], "script.csv:4: the id 'a' is used at script.csv:2"),
        (["A,A", "a,B"], "script.csv:3: the id 'a' differs from 'A' of script.csv:2 only in"),
        (["é,A", "e\u0301,B"], "script.csv:3: the id 'e\u0301' differs from 'é' of script.csv:2"),
        ([",A"], "script.csv:2: this line has no id"),
        (['a,"A', *["x"] * 200], 'script.csv:2: a cell begins with a quote (") that is'),
        (["a,A", "b,B, B"], "script.csv:3: has 3 cells, and the head 2 columns"),
    ],
)  # fmt: skip
def test_faults_of_rows_have_their_place(game, rows, fault):
    put(game, "script.csv", text="\n".join(["id,english", *rows]))
    assert fault in refusal(game, languages="[english]", cast=None, character="crab")


def test_all_faults_are_told_at_once(game):
    rows = "".join(f"a/{number},Hello.,Hallo.\n" for number in range(100))
    put(game, "script.csv", text=f"id,english,german\n{rows}")
    told = refusal(game, cast=None, character="crab").splitlines()
    assert told[0].startswith("script.csv:2: ")
    assert told[1].startswith("script.csv:3: ")
    assert told[-1] == "and 88 more of this script"


def test_the_encoding_of_a_script_is_a_field_of_the_project(game):
    (game / "script.csv").write_bytes("id,text\na,Grüße.\n".encode("cp1252"))
    one = {"languages": "[german]", "cast": None, "character": "crab"}
    assert "name its encoding (`encoding: cp1252`)" in refusal(game, **one)
    assert planned(game, encoding="cp1252", **one)[0].text == "Grüße."
    assert "unknown encoding" in refusal(game, encoding="cp99", **one)


def test_ids_of_unity_are_its_keys(game):
    put(game, "script.csv", text="Key,Id,English(en)\nintro_1,231455,Hello.\n")
    one = {"languages": "[english]", "cast": None, "character": "crab"}
    assert [line.name for line in planned(game, **one)] == ["intro_1"]


@pytest.mark.parametrize(
    ("head", "changed", "fault"),
    [
        ("id,english", {}, "which column is the text in german?"),
        ("english,german", {}, "has no column of ids"),
        ("id,english,german", {"columns": "{speaker: rolle}"}, "has no column 'rolle'"),
        ("id,english,german", {"columns": "{id: idd}"}, "did you mean 'id'?"),
        ("id,english,german", {"columns": "{text: english}"}, "one column for english and german"),
        ("id,english,german", {"cast": "{anna: crab}"}, "no character for no speaker"),
        ("id,english,german", {"cast": '{"*": crb}'}, "did you mean 'crab'?"),
        ("id,english,german", {"languages": "[english, germn]"}, "did you mean 'german'?"),
        ("id,english,german", {"languages": "[english, en]"}, "are the same language, english"),
        ("id,english,german", {"lines": "no.csv"}, "no.csv: no such file"),
        ("id,english,german", {"lines": None}, "no `lines`"),
        ("id,english,german", {"outputs": None}, "no `outputs`"),
        ("id,english,german", {"outputs": "a.csv"}, "add {id} to it"),
        ("id,english,german", {"outputs": "'{id}.csv'"}, "add {language} to it"),
        ("id,english,german", {"outputs": "'{language}/{id}.xyz'"}, "no writer for '.xyz'"),
        ("id,english,german", {"limits": "{contcts: 0}"}, "did you mean 'contacts'?"),
        ("id,english,german", {"reports": "report.pdf"}, "unknown format of the report"),
        ("id,english,german", {"outputs": "'../{id}.csv'"}, "is outside the project's folder"),
        ("id,english,german", {"audio": "'../{id}.wav'"}, "is outside the project's folder"),
        ("id,english,german", {"lines": "/etc/passwd"}, "is outside the project's folder"),
        ("id,english,german", {"outputs": "'{foo}/{id}.csv'"}, "unknown placeholder '{foo}'"),
        ("id,english,german", {"languages": "{english: a/b}"}, "has a '/'"),
    ],
)
def test_faults_of_a_project_are_told_with_their_cure(game, head, changed, fault):
    put(game, "script.csv", text=f"{head}\na,Hello.,Hallo.\n")
    assert fault in refusal(game, **{"cast": '{"*": crab}', **changed})


def test_several_characters_of_a_line_need_files_of_their_own(game):
    outputs = "'{language}/{id}.csv'"
    assert len(planned(game, outputs=outputs)) == 4, "each line is made on one character"
    told = refusal(game, outputs=outputs, cast='{"*": [crab, facefx]}')
    assert "add {character} to it" in told


def test_hundreds_of_names_are_counted(game):
    put(game, "script.csv", text=SCRIPT + "".join(f"l{n},S{n:03},x,y\n" for n in range(400)))
    told = refusal(game, cast="{anna: crab, bob: crab}")
    assert told.startswith("script.csv:4: no character for 'S000', 'S001', ")
    assert told.endswith("'S023' and 376 more; add them or '*' to `cast`")
    told = refusal(game, cast="{" + ", ".join(f"S{n}: nobody{n}" for n in range(400)) + "}")
    assert told.count("unknown character") == 12
    last = "and 388 more of this project; `lipsync-lang validate` lists all"
    assert told.splitlines()[-1] == last


def test_two_lines_never_share_a_file(game):
    put(game, "script.csv", text="id,speaker,english\nb-c,a,Hello.\nc,a-b,Hello.\n")
    told = refusal(game, languages="[english]", outputs="'{speaker}-{id}.csv'")
    assert told.startswith("script.csv:3: the output a-b-c.csv is also one of script.csv:2")


def test_outputs_do_not_follow_a_link_out_of_the_project(game, tmp_path_factory):
    (game / "takes").symlink_to(tmp_path_factory.mktemp("elsewhere"))
    assert "by a link" in refusal(game)


def test_speakers_in_paths_are_names_of_files_too(game):
    outputs = "'{language}/{speaker}/{id}.csv'"
    put(game, "script.csv", text="id,speaker,english\na,,Hello.\n")
    [line] = planned(game, languages="[english]", outputs=outputs)
    assert line.outputs == (("csv", "english/narrator/a.csv"),)
    put(game, "script.csv", text="id,speaker,english\na,../x,Hello.\n")
    assert "the speaker '../x' has a '/'" in refusal(game, languages="[english]", outputs=outputs)


def test_every_fault_of_a_project_has_its_place_in_the_file(cli, game):
    put(
        game,
        "lipsync.yaml",
        text="kind: project\nformat: 1\nlanguages: [english, germn]\ncast:\n  anna: [crab, crb]\n",
    )
    ended = cli("validate", "--no-tests", "lipsync.yaml")
    places = [one.split(" ")[:2] for one in ended.out.splitlines() if one.startswith("lipsync")]
    assert places == [["lipsync.yaml:3:22:", "P210"], ["lipsync.yaml:5:16:", "P203"]]
