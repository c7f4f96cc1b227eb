"""Languages of files by their names and those of their folders."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.packs.finding import Finder
from lipsync_lang.packs.language_files import languages_of_files, spoken_in

FINDER = Finder(project=None)

FOLDERS = {
    "renpy": ("script.rpy -", "a/b.rpy -", "tl/german/script.rpy german", "tl/None/c.rpy -"),
    "tags": ("de/a.json german", "pt-BR/a.json portuguese-br", "fr/more/b.json french"),
    "files": ("de.po german", "fr.po french", "en.po english"),
    "android": ("values/s.xml -", "values-de/s.xml german", "values-night/s.xml -"),
    "apple": ("Base.lproj/L.strings -", "it.lproj/L.strings italian"),
    "java": (
        "menu.properties -",
        "menu_fr.properties french",
        "menu_it.properties italian",
        "a.x -",
    ),
    "both orders": ("de_menu.csv german", "en_menu.csv english"),
    "words": ("it.txt -", "was.txt -", "late.txt -"),
    "words at the end": ("act_it.txt -", "scene_no.txt -"),
    "a folder of work": ("polish.rpy -", "script.rpy -", "menu.rpy -"),
}


@pytest.mark.parametrize("case", FOLDERS)
def test_files_are_in_the_language_that_they_and_their_neighbours_are_named_after(case):
    wanted = dict(row.split(" ") for row in FOLDERS[case])
    files = [Path("game", name) for name in wanted]
    found = languages_of_files(files, Path("game"), FINDER.language_of)
    assert {file: own or "-" for file, own in found.items()} == dict(
        zip(files, wanted.values(), strict=True)
    )


@given(st.lists(st.sampled_from(["de", "french", "x", "y_it", "y", "b"]), min_size=1, max_size=6))
def test_every_file_of_a_folder_is_in_a_language_or_named_after_another(parts):
    files = [Path("game", *parts[:at], f"{part}.json") for at, part in enumerate(parts)]
    told = languages_of_files(files, Path("game"), FINDER.language_of)
    asked = {"german": ("german", "de"), "english": ("english", "en")}
    spoken = spoken_in(files, Path("game"), asked, FINDER)
    for file in files:
        assert spoken[file] or told[file] not in asked
        if told[file] is None:
            assert "english" in spoken[file]


def test_a_tag_is_of_its_dialect_unless_the_language_itself_is_asked_for():
    files = [Path("game/en/a.po"), Path("game/de/a.po")]
    british = {"english-uk": ("english-uk", "en-GB")}
    assert spoken_in(files, Path("game"), british, FINDER)[files[0]] == {"english-uk"}
    both = british | {"english": ("english", "en")}
    assert spoken_in(files, Path("game"), both, FINDER)[files[0]] == {"english"}
    assert not spoken_in(files, Path("game"), both, FINDER)[files[1]]
