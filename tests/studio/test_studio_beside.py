"""The line of the studio on a second character."""

import numpy as np
import pytest
from studio_calls import Caller

from lipsync_lang.studio.line_settings import LineSettings
from lipsync_lang.studio.routes.line_routes import performed_beside
from lipsync_lang.studio.workshop import Workshop


@pytest.fixture
def workshop(tmp_path):
    made = Workshop(tmp_path, engine="none")
    made.open("english", "facefx")
    return made


def test_the_second_character_says_the_line_as_it_would_alone(workshop):
    workshop.speak("buy maps")
    found = performed_beside(workshop, "crab")
    workshop.open("english", "crab")
    alone = workshop.perform_shown()
    assert np.array_equal(found.weights, alone.weights)
    assert np.array_equal(found.times, alone.times)


def test_the_delivery_is_taken_over_as_far_as_the_character_has_it(workshop):
    workshop.speak("buy maps")
    plain = performed_beside(workshop, "crab")
    workshop.settings = LineSettings(styles={"angry": 1.0, "smirk": 1.0}, bends={"W": [[0.2, 0.5]]})
    styled = performed_beside(workshop, "crab")
    workshop.settings = LineSettings(styles={"angry": 1.0})
    angry = performed_beside(workshop, "crab")
    assert np.array_equal(styled.weights, angry.weights), "no smirk and no W"
    assert not np.array_equal(plain.weights, angry.weights[:, : plain.weights.shape[1]])


def test_an_edit_of_the_second_character_is_seen(workshop):
    workshop.speak("buy maps")
    before = performed_beside(workshop, "facefx").weights
    path, text = workshop.editable("character")
    workshop.edit("Lower", [(path, (), text), (path, ("targets", "ae"), {"open": 0.1})])
    assert not np.array_equal(performed_beside(workshop, "facefx").weights, before)


def test_the_model_is_sent_once_and_an_unknown_character_is_refused(workshop):
    server = Caller(workshop)
    rest = server.post("beside", {"character": "crab", "face": True})
    assert rest.status == 200
    workshop.speak("buy maps")
    whole = server.post("beside", {"character": "crab", "face": True})
    take = server.post("beside", {"character": "crab"})
    assert len(take.content) < len(whole.content) / 4
    refused = server.post("beside", {"character": "crap"})
    assert refused.status == 422
    assert "crab" in refused.json["error"]
