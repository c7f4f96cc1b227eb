"""Faults that keep a project from being built: `validate` and `build` name the same."""

import pytest
from lanes import needs_plug_ins

from lipsync_lang.base import extras
from lipsync_lang.commands import doctor_checks

HEAD = "kind: project\nformat: 1\nname: game\n"
SOUND = {
    "lines": "script.csv",
    "languages": "[english, german]",
    "character": "facefx",
    "audio": "'vo/{language}/{id}.wav'",
    "outputs": "'takes/{language}/{id}.csv'",
}
SCRIPT = "id,speaker,english,german\na,anna,Hello.,Hallo.\nb,bob,Well.,Nun.\n"
TWELVE = [
    "english", "german", "french", "mandarin", "japanese", "korean", "russian", "hebrew", "thai",
    "arabic", "hindi", "vietnamese",
]  # fmt: skip


@pytest.fixture
def game(tmp_path, monkeypatch):
    """A folder with a script in two languages."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.csv").write_text(SCRIPT)
    return tmp_path


def state(game, **changed):
    """Write a project with some fields changed; None removes a field."""
    stated = {name: text for name, text in (SOUND | changed).items() if text is not None}
    (game / "lipsync.yaml").write_text(
        HEAD + "".join(f"{name}: {text}\n" for name, text in stated.items())
    )


def told(cli, *command):
    """Return the code, and the located lines of what a command says."""
    ended = cli(*command)
    lines = (ended.out + ended.err).replace("lipsync-lang: ", "").splitlines()
    return ended.code, [line for line in lines if line.startswith("lipsync.yaml:")]


@pytest.mark.parametrize(
    ("changed", "place", "words"),
    [
        ({"audio": "'vo/{id}.wav'"}, "7:8: P403", "the same file for all languages"),
        ({"timings": "'vo/{id}.json'"}, "9:10: P403", "the same file for all languages"),
        ({"audio": "'vo/{language}/one.wav'"}, "7:8: P403", "the same file for all lines"),
        ({"languages": "[schinese, tchinese]"}, "5:23: P402", "the same language, mandarin"),
        ({"languages": "[english, germn]"}, "5:22: P210", "unknown language 'germn'"),
        ({"languages": "[english, foo:de]"}, "5:22: P210", "unknown language 'foo:de'"),
        ({"languages": None}, "1:1: P401", "no `languages`"),
        ({"character": None}, "1:1: P401", "no `character`"),
        ({"outputs": None}, "1:1: P401", "no `outputs`"),
        ({"outputs": "[csv, json]"}, "8:11: P404", "'csv' is a format, not a file"),
        ({"outputs": "'csv:csv:/abs/{id}.csv'"}, "8:10: P106", "write FORMAT:FILE once"),
        ({"outputs": "'{language}/{id}.xyz'"}, "8:10: P404", "no writer for '.xyz'"),
        ({"outputs": "'{language}.csv'"}, "8:10: P403", "the same file for all lines"),
        ({"limits": "{contcts: 0}"}, "9:19: P404", "unknown measure 'contcts'"),
        ({"reports": "report.pdf"}, "9:10: P404", "unknown format of the report"),
        ({"character": "rhubarb", "outputs": "['{language}/{id}.csv', '{language}/{id}.glb']"},
         "8:34: P405", "cannot be made on rhubarb: there is no model"),
        pytest.param({"fps": 30, "outputs": "'{language}/{id}.azure.json'"}, "8:10: P405",
                     "60 frames", marks=needs_plug_ins),
        ({"motion": "slow"}, "9:9: P107", "`preset` must be one of default, paper"),
        ({"recordings": "required"}, "9:13: P407", "english: 2 lines without a recording"),
        ({"columns": "{id: idd}"}, "4:8: P407", "script.csv:1: has no column 'idd'"),
    ],
)  # fmt: skip
def test_validate_says_what_a_build_refuses(cli, game, changed, place, words):
    state(game, **changed)
    code, validated = told(cli, "validate", "--no-tests")
    assert code == 1
    assert [one for one in validated if one.startswith(f"lipsync.yaml:{place} ") and words in one]
    ended = cli("build", "--dry-run")
    assert ended.code
    assert words in ended.err
    assert (f"lipsync.yaml:{place} " in ended.err) == ("columns" not in changed)


def test_a_project_without_a_script_serves_other_commands(cli, game):
    state(game, lines=None, outputs="line.csv", languages=None, language="english", audio=None)
    assert told(cli, "validate", "--no-tests") == (0, [])
    state(game, lines=None, outputs="line.xyz", languages=None, language="english", audio=None)
    code, validated = told(cli, "validate", "--no-tests")
    assert (code, len(validated)) == (1, 1)
    assert "P404" in validated[0]


def test_a_mistyped_path_of_recordings_is_a_warning(cli, game):
    state(game, audio="'voo/{language}/{id}.wav'")
    assert told(cli, "validate", "--no-tests") == (0, []), "a new project has no recordings yet"
    (game / "vo/german").mkdir(parents=True)
    (game / "vo/german/a.wav").write_text("x")
    for command in (("validate", "--no-tests"), ("build", "--dry-run")):
        code, lines = told(cli, *command)
        assert code == 0
        words = "no file matches 'voo/{language}/{id}.wav', so voices speak 4 lines"
        assert lines == [f"lipsync.yaml:7:8: W315 warning: {words}"]
    (game / "voo/german").mkdir(parents=True)
    (game / "voo/german/a.wav").write_text("x")
    assert told(cli, "validate", "--no-tests") == (0, [])


def test_timings_are_as_good_as_recordings(cli, game):
    state(game, recordings="required", languages="[german]")
    (game / "vo/german").mkdir(parents=True)
    for name in "ab":
        (game / f"vo/german/{name}.json").write_text('[{"label": "m", "start": 0, "end": 0.2}]')
    assert told(cli, "validate", "--no-tests")[0] == 0
    (game / "vo/german/b.json").unlink()
    assert "german: 1 line without a recording" in cli("build").err
    state(game, recordings="required", languages="[german]", audio=None)
    assert "german: 2 lines without a recording" in cli("build").err


def test_all_that_is_not_installed_is_told_before_any_work(cli, game, monkeypatch):
    monkeypatch.setattr(extras, "importable", lambda _: False)
    (game / "script.csv").write_text(f"id,{','.join(TWELVE)}\na{',x' * len(TWELVE)}\n")
    state(
        game, languages=f"[{', '.join(TWELVE)}]",
        outputs="['{language}/{id}.csv', 'mp4:{language}/{id}.mp4']",
    )  # fmt: skip
    for command in (("validate", "--no-tests"), ("build",)):
        ended = cli(*command)
        text = ended.out + ended.err
        assert ended.code
        assert text.count("not installed") == 1
        assert "lipsync.yaml:5:12: P406 not installed: " in text
        assert "speech (for english, german, french and 8 more), mandarin (for mandarin)" in text
        assert text.count("pip install") == 1
        assert '"lipsync-lang[japanese,mandarin,speech,tashkeel,thaiphon,video]"' in text
    assert not (game / ".lipsync_lang").exists()


def test_only_what_the_selected_lines_need_must_be_installed(cli, game, monkeypatch):
    there = extras.importable
    monkeypatch.setattr(extras, "importable", lambda name: name != "pypinyin" and there(name))
    (game / "script.csv").write_text("id,english,mandarin\na,Hello.,你好\n")
    state(game, languages="[english, mandarin]")
    ended = cli("build", "--dry-run")
    assert "not installed: mandarin (for mandarin)" in ended.err
    assert cli("build", "--dry-run", "-l", "english").code == 0
    (game / "vo/mandarin").mkdir(parents=True)
    (game / "vo/mandarin/a.json").write_text('[{"label": "m", "start": 0, "end": 0.2}]')
    assert cli("build", "--dry-run").code == 0, "lines with timings need no engine"


def test_a_spreadsheet_without_its_reader_is_told_with_the_rest(cli, game, monkeypatch):
    monkeypatch.setattr(extras, "importable", lambda _: False)
    state(game, lines="script.xlsx")
    assert "[audio,speech,tables]" in cli("build").err


def test_one_of_two_engines_is_enough(cli, game, monkeypatch):
    there = extras.importable
    monkeypatch.setattr(
        extras, "importable", lambda name: not name.startswith("dengjen") and there(name)
    )
    (game / "script.csv").write_text("id,arabic\na,سلام\n")
    state(game, languages="[arabic]", audio=None)
    assert cli("build", "--dry-run").code == 0


# Other commands


def test_coverage_gives_the_verdict_of_a_build_on_languages(cli, game):
    (game / "script.csv").write_text("id,schinese,tchinese\na,你好,你好嗎\n")
    state(game, languages="[schinese, tchinese]", audio=None)
    whole = cli("coverage")
    assert whole.code
    for command in (("build", "--dry-run"), ("validate", "--no-tests")):
        ended = cli(*command)
        fault = next(line for line in (ended.out + ended.err).splitlines() if "P402" in line)
        assert fault.removeprefix("lipsync-lang: ") in whole.err


def test_columns_of_one_language_are_told_apart_in_every_form(cli, tmp_path, monkeypatch):
    pytest.importorskip("pypinyin", reason="reads Chinese")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.csv").write_text("id,schinese,tchinese\na,你好,你好嗎\n")
    asked = ("coverage", "script.csv", "-l", "schinese", "-l", "tchinese", "-c", "facefx")
    for form in ("text", "csv", "json", "html"):
        written = cli(*asked, "--format", form).out
        assert "schinese" in written, form
        assert "tchinese" in written, form


def test_readers_that_are_missing_are_told_at_once(cli, game, monkeypatch):
    monkeypatch.setattr(extras, "importable", lambda _: False)
    (game / "script.csv").write_text(f"id,{','.join(TWELVE)}\na{',x' * len(TWELVE)}\n")
    state(game, languages=f"[{', '.join(TWELVE)}]", audio=None)
    told_of = cli("coverage").err
    assert "japanese (for japanese), mandarin (for mandarin)" in told_of
    assert '"lipsync-lang[japanese,mandarin,speech,tashkeel,thaiphon]"' in told_of
    assert "not installed: mandarin (for mandarin)" in cli("transcribe", "-l", "zh", "好").err


def test_the_doctor_parts_what_the_project_needs_from_the_rest(cli, game, monkeypatch):
    there = extras.importable
    monkeypatch.setattr(extras, "importable", lambda name: name != "pypinyin" and there(name))
    monkeypatch.setattr(doctor_checks, "fault_of", lambda *_: "")
    state(game, languages="[english, mandarin]", audio=None)
    ended = cli("doctor")
    head, _, rest = ended.out.partition("this project needs:\n")
    own, _, optional = rest.partition("optional:\n")
    assert head.startswith("always needed:\n")
    assert "extra mandarin" in own
    assert "to install" in own
    assert '"lipsync-lang[mandarin]"' in own
    assert "extra plot" in optional
    assert ended.code == 1
