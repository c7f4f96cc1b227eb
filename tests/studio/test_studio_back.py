"""The page of the studio waits for a studio that is started again."""

from places import TESTS
from test_line_page import STATIC, node


def test_the_page_tells_why_it_cannot_go_on_and_tries_again():
    told = node(TESTS / "browser" / "back.mjs", STATIC)
    stopped, refused = told["told"]
    assert stopped.startswith("The studio has stopped")
    assert refused == "The studio cannot go on yet: no pose set"
    assert told["opened"] == 2, "two requests at once open the pair together, and once more"
    assert told["answers"] == [{"server": "second"}] * 2
