"""Files of gettext: encodings, entries without a translation, and speakers in comments."""

import pytest

from lipsync_lang.text.lines import read_lines


def write(path, text, encoding="utf-8"):
    path.write_text(text, encoding)
    return path


def read(path, **options):
    return list(read_lines(path, **options))


def test_a_file_of_a_translator_names_its_encoding(tmp_path):
    text = 'msgid ""\nmsgstr "Content-Type: text/plain; charset=ISO-8859-1\\n"\n\n'
    path = write(tmp_path / "a.po", text + 'msgid "a"\nmsgstr "ä"\n', "latin-1")
    assert [line.text for line in read(path)] == ["ä"]


def test_what_is_not_translated_is_named(tmp_path):
    path = write(tmp_path / "a.po", 'msgid "a"\nmsgstr "b"\n\nmsgid "c"\nmsgstr ""\n')
    with pytest.warns(UserWarning, match="a.po: left out 1 empty or untranslated entry"):
        assert [line.text for line in read(path)] == ["b"]


SPOKEN_BY = {
    "#. Speaker: Bob": "Bob",
    "#. speaker: rhea (worried)": "rhea",
    "# CHARACTER = Old Man, aside": "Old Man",
    "#. [message]: speaker=Lord D'Artagnan": "Lord D'Artagnan",
    '#. InfoMetaData:\t"Speaker" : "Bob"': "Bob",
    "#. Bob\n#. Actor: Ann\n#. Role: Bob": "Ann",
    "#. The role: a sad one\n#: speaker=1\n#, speaker: x": "",
    '#. Speaker: Bob\n#~ msgid "old"\n#~ msgstr "alt"\n': "",
    '#, fuzzy\n#~ msgid "old"\n#~ msgstr "alt"\n': "",
    "#. " + "speaker " * 100_000: "",
}


@pytest.mark.parametrize("comment", SPOKEN_BY, ids=lambda comment: comment[:24])
def test_comments_of_gettext_name_the_speaker(comment, tmp_path):
    text = f'{comment}\nmsgid "a"\nmsgstr "b"\n\nmsgid "c"\nmsgstr "d"\n'
    lines = read(write(tmp_path / "a.po", text))
    assert [(line.speaker, line.text) for line in lines] == [(SPOKEN_BY[comment], "b"), ("", "d")]


@pytest.mark.parametrize(
    ("stated", "comment"),
    [
        ("Sprecher", "#. sprecher: Bob"),
        ("[{speaker}]", "#. Scene 2 [Bob] sadly"),
        ("said by {speaker}", "# Said  by  Bob "),
        ("{speaker} says", "#. Bob says"),
        ("2", "#. Speaker: Bob"),
    ],
)
def test_a_project_states_how_comments_name_the_speaker(stated, comment, tmp_path):
    path = write(tmp_path / "a.po", f'{comment}\nmsgid "a"\nmsgstr "b"\n')
    assert [line.speaker for line in read(path, speaker=stated)] == ["Bob"]


def test_a_form_of_speakers_that_no_comment_has_is_told(tmp_path):
    path, remarks = write(tmp_path / "a.po", '#. Bob\nmsgid "a"\nmsgstr "b"\n'), []
    read(path, speaker="[{speaker}]", remark=remarks.append)
    assert remarks == [f"{path}: no comment has a speaker of the form '[{{speaker}}]'"]


def test_originals_are_read_where_no_sound_entry_is_translated(tmp_path):
    text = '#, fuzzy\nmsgid "a"\nmsgstr "b"\n\nmsgid "c"\nmsgid_plural "d"\nmsgstr[0] ""\n'
    assert [line.text for line in read(write(tmp_path / "a.po", text))] == ["a", "c", "d"]
