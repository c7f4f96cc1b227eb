"""A pose set that extends another states only what differs, in names of its own."""

import numpy as np
import pytest

import lipsync_lang as ll
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import PoseSet
from lipsync_lang.packs.pack import FilePlace

LINE = ll.Schedule(
    ("_", "UW", "M", "AA", "S", "_"), (0, 0.2, 0.4, 0.5, 0.8, 1.0, 1.2), notation="arpabet"
)

HEAD = "kind: poseset\nformat: 1\nname: {name}\n"

RENAMED = "extends: vrm\nrenamed: {aa: wide, happy: glad}\nposes: {wide: {title: agape}}\n"


@pytest.fixture
def written(folder):
    def write(name, more, file="poseset.yaml"):
        path = folder / "posesets" / name / file
        path.parent.mkdir(parents=True, exist_ok=True)
        own = name if file == "poseset.yaml" else path.stem
        path.write_text(HEAD.format(name=own) + more, "utf-8")
        return path

    return write


def test_a_renamed_pose_set_performs_as_its_parent(written):
    written("own", RENAMED)
    own, parent = (ll.resolve("english", name) for name in ("own", "vrm"))
    assert own.poses == ("wide", *parent.poses[1:])
    for styles in ({}, {"happy": 1.0}):
        made, known = (one.perform(LINE, styles=styles) for one in (own, parent))
        assert np.array_equal(made.weights, known.weights)
    assert made.poses[len(own.poses)] == "glad"


def test_names_are_handed_down_through_each_parent(written):
    written("own", RENAMED)
    written("grandchild", "extends: own\nrenamed: {wide: gape, ih: slit}\nposes: {gape: {}}\n")
    made, first = (Library().poseset(name).model for name in ("grandchild", "vrm"))
    assert [*made.poses][:3] == ["gape", "slit", "ou"]
    assert made.poses["gape"].title == "agape"
    assert made.targets["ay"][0].weights == {"gape": first.targets["ay"][0].weights["aa"]}


def test_a_child_states_what_differs_and_keeps_the_rest(written):
    written("own", "extends: vrm\nposes: {aa: {title: agape}}\ntargets: {aa: {aa: 0.5}}\n")
    made, parent = (Library().poseset(name).model for name in ("own", "vrm"))
    assert made.poses["aa"] == parent.poses["aa"].model_copy(update={"title": "agape"})
    assert made.targets["aa"][0].weights == {"aa": 0.5}
    same = PoseSet.model_fields.keys() - {"name", "extends", "poses", "targets"}
    assert [name for name in same if getattr(made, name) != getattr(parent, name)] == []
    assert {**made.targets, "aa": ()} == {**parent.targets, "aa": ()}


def test_a_pose_set_of_its_parents_name_stands_in_front_of_it(written):
    written("vrm", "extends: vrm\nposes: {aa: {}}\ntargets: {aa: {aa: 0.5}}\n")
    made = Library().poseset("vrm")
    assert made.model.targets["aa"][0].weights == {"aa": 0.5}
    assert "ow" in made.model.targets
    assert not validate(Library())


def test_targets_of_a_file_beside_are_found_there(written):
    path = written("own", "poses: {aa: {}}\ntargets:\n  aa: {aa: 0.5}\n", "figures.yaml")
    written("own", "extends: figures.yaml\nposes: {aa: {}}\n")
    made = Library().poseset("own")
    assert made.model.targets["aa"][0].weights == {"aa": 0.5}
    assert made.where(("targets", "aa"), key=True) == FilePlace(path, 6, 3)


def test_a_stated_target_is_its_own_look(written):
    written("own", "extends: arkit\nposes: {jawOpen: {}}\ntargets: {aa: {jawOpen: 0.5}}\n")
    made, parent = (Library().poseset(name).model for name in ("own", "arkit"))
    assert made.looks.keys() == parent.looks.keys() - {"aa"}


@pytest.mark.parametrize(
    ("more", "place", "what"),
    [
        ("extends: vrmm\nposes: {aa: {}}\n", "4:10", "P210 unknown pose set 'vrmm'"),
        ("extends: none.yaml\nposes: {aa: {}}\n", "4:10", "P210 unknown pose set 'none.yaml'"),
        ("extends: own\nposes: {aa: {}}\n", "4:10", "P210 there is no other pose set 'own'"),
        ("extends: other\nposes: {aa: {}}\n", "4:10", "P211 pose sets extend each other"),
        ("extends: vrm\nrenamed: {as: a}\nposes: {aa: {}}\n", "5:11", "P201 unknown pose 'as'"),
        (
            "extends: vrm\nposes: {aa: {}}\ntargets: {aa: {as: 1}}\n",
            "6:16",
            "P201 unknown pose 'as'",
        ),
        ("extends: vrm\nposes: {aa: {}}\ntargets: {aa: {aa: 2}}\n", "6:20", "P104 `aa` must be"),
    ],
)
def test_a_fault_is_told_at_its_line(written, more, place, what):
    path = written("own", more)
    written("other", "extends: own\nposes: {aa: {}}\n")
    told = [str(fault) for fault in validate(Library(), [path])]
    assert [one for one in told if f"poseset.yaml:{place}: {what}" in one], told


def test_a_fault_in_the_file_beside_is_told_there(written):
    path = written("own", "poses: {aa: {}}\ntargets: {aa: {as: 1}}\n", "figures.yaml")
    own = written("own", "extends: figures.yaml\nposes: {aa: {}}\n")
    found = {(f.file, f.line, f.code) for f in validate(Library(), [own]) if f.severity == "fault"}
    assert found == {("posesets/own/figures.yaml", 5, "P201")}, path
