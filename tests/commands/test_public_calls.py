"""Arguments of the public functions: single values or lists, names or files, and choices."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from packs_tree import CHILD, PARENT, POSESET, plant, put

import lipsync_lang as ll
from lipsync_lang.packs.library import Library
from lipsync_lang.reports.coverage import coverage
from lipsync_lang.reports.quality.baselines import BASELINES, compare
from lipsync_lang.text.lines.line_readers import Line

SCHEDULE = ll.Schedule(("P", "2"), [0, 0.1, 0.3])


@pytest.fixture
def project(tmp_path):
    """A folder of packs that is not the current one."""
    return plant(tmp_path / "project")


# One folder or several


@pytest.mark.parametrize("form", [str, Path, lambda p: [str(p)], lambda p: iter([p])],
                         ids=["text", "path", "list", "iterator"])  # fmt: skip
def test_paths_are_one_or_several(project, form):
    performer = ll.resolve("parent", "face", paths=form(project))
    assert (performer.language, performer.paths) == ("parent", (project,))
    assert ll.transcribe("moi", "parent", paths=form(project)).phonemes == ("p", "a")
    assert ll.speak("moi", "parent", engine="none", paths=form(project)).words[0].text == "moi"
    (found,) = coverage([Line("moi", "line")], "parent", "face", paths=form(project)).reports
    assert found.language == "parent"
    assert Library(form(project)).language("child").path.parent.parent == project


def test_a_folder_that_is_not_there_is_told_whole(project):
    with pytest.raises(ll.PackError, match=r"project/nowhere: no such folder"):
        ll.resolve("parent", "face", paths=str(project / "nowhere"))


# Files for names


@pytest.mark.parametrize("form", [Path, str])
def test_packs_are_named_by_their_files_too(project, form):
    language = form(project / "languages" / "child.yaml")
    for character in ("characters/anna.yaml", "posesets/face/poseset.yaml"):
        name = "anna" if "anna" in character else "face"
        performer = ll.resolve(language, form(project / character))
        assert (performer.language, performer.character) == ("child", name)
        again = ll.resolve("child", name, paths=project)
        assert np.array_equal(performer.perform(SCHEDULE).weights, again.perform(SCHEDULE).weights)
    assert ll.transcribe("moi", language).phonemes == ("f",)
    (found,) = coverage([Line("moi", "line")], language, "face", paths=project).reports
    assert found.language == "child"


def test_a_file_needs_no_folder_of_packs_around_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    base = plant(tmp_path / "base")
    put(tmp_path, "fresh.yaml", CHILD.replace("child", "fresh").replace("qaa-XX", "qab"))
    put(tmp_path, "mouths/apart/poseset.yaml", POSESET.replace("name: face", "name: apart"))
    performer = ll.resolve("fresh.yaml", Path("mouths/apart/poseset.yaml"), paths="base")
    assert (performer.language, performer.character) == ("fresh", "apart")
    assert performer.paths == (
        tmp_path / "fresh.yaml", tmp_path / "mouths/apart/poseset.yaml", base,
    )  # fmt: skip
    assert compare(performer, SCHEDULE).keys() > BASELINES.keys()


def test_a_file_comes_before_all_others_of_its_name(project, tmp_path):
    mine = put(tmp_path, "mine/languages/parent.yaml", PARENT.replace("voice: eo", "voice: eu"))
    put(tmp_path, "mine/characters/anna.yaml", "kind: character")
    anna = project / "characters" / "anna.yaml"
    assert ll.resolve(mine, anna, paths=project).compiled.manner["voice"][1] == "eu"


def test_a_file_of_another_kind_is_refused(project):
    language, poseset = project / "languages/child.yaml", project / "posesets/face/poseset.yaml"
    with pytest.raises(ll.PackError, match=r"child\.yaml: holds a pack of kind language, not a ch"):
        ll.resolve(language, language)
    with pytest.raises(ll.PackError, match="holds a pack of kind poseset, not a language"):
        ll.speak("moi", poseset)
    with pytest.raises(ll.PackError, match=r"gone\.yaml: no such file; name a language, or"):
        ll.resolve("gone.yaml", "face")


# What was found once is found again


@pytest.mark.parametrize("name", BASELINES)
def test_baselines_read_the_packs_that_the_performer_was_made_of(project, name):
    performer = ll.resolve("parent", "face", paths=project)
    assert BASELINES[name](performer, SCHEDULE).poses == performer.poses
    assert name in compare(performer, SCHEDULE)


# One text or several


def test_one_text_gives_one_result_and_several_an_iterator(project):
    options = {"paths": project}
    assert isinstance(ll.transcribe("moi", "parent", **options), ll.Transcript)
    several = ll.transcribe(iter(["moi", "moi moi"]), "parent", **options)
    assert iter(several) is several
    assert [t.phonemes for t in several] == [("p", "a"), ("p", "a", "p", "a")]

    options |= {"engine": "none"}
    assert isinstance(ll.speak("moi", "parent", **options), ll.Schedule)
    several = ll.speak(("moi", "moi moi"), "parent", **options)
    assert iter(several) is several
    assert [len(s.words) for s in several] == [1, 2]
    assert list(ll.speak([], "parent", **options)) == []


# Choices


def test_choices_are_checked():
    wrong = {"gaps": "maybe", "unknown": "rests"}
    for name, value in wrong.items():
        with pytest.raises(ll.LipsyncError, match=f"`{name}` is '{value}'; it is one of 'error'"):
            ll.resolve("english", "facefx", **{name: value})
    with pytest.raises(ll.LipsyncError, match="'error', 'rest', 'nearest'"):
        replace(ll.resolve("english", "facefx"), unknown=None)


@pytest.mark.parametrize("given", ["Hello", Path("hello.wav"), None])
def test_what_is_no_schedule_is_told_with_what_is(project, given):
    performer = ll.resolve("parent", "face", paths=project)
    for perform in (performer.perform, lambda one: performer.perform_many([one])):
        with pytest.raises(ll.ScheduleError, match=r"is no schedule: pass ll\.speak\(TEXT"):
            perform(given)


def test_unknown_labels_are_asked_for_when_resolving(project):
    strange = ll.Schedule(("P", "strange"), [0, 0.1, 0.3], notation="first")
    with pytest.raises(ll.ScheduleError, match="strange"):
        ll.resolve("parent", "face", paths=project).perform(strange)
    calm = ll.resolve("parent", "face", paths=project, unknown="rest").perform(strange)
    assert calm.source.performer.unknown == "rest"
    assert calm.source.performer.common_phonemes(strange)[0].tolist()[-1] == 0
