"""The page of a coverage document: complete, safe, small and reproducible."""

import json
import re
from base64 import b64encode
from functools import cache
from hashlib import sha256
from html.parser import HTMLParser
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, swept

from lipsync_lang.base.errors import count
from lipsync_lang.base.presentation.wording import (
    NBSP,
    folder,
    gathered,
    hours,
    listed,
    percent,
    percentage_text,
)
from lipsync_lang.reports.coverage.page import page

SOUNDS = [
    "ah", "aa", "ao", "eh", "er", "ih", "w", "ow", "aw", "oy", "ay",
    "h", "r", "l", "s", "sh", "th", "f", "d", "kg", "bmp",
]  # fmt: skip
LANGUAGES = {
    "english": "English",
    "spanish": "Spanish",
    "mandarin": "Mandarin",
    "french": "French",
    "german": "German",
    "italian": "Italian",
    "japanese": "Japanese",
    "polish": "Polish",
    "portuguese-br": "Portuguese (Brazil)",
    "arabic": "Arabic",
}
CHARACTERS = {
    "facefx": "facefx",
    "mira": "facefx",
    "the-crab": "crab",
    "vex": "arkit",
    "narrator": "facefx",
}
LINES = {
    "english": "I told you, Bob: nobody moves the maps before we find a safe way down.",
    "mandarin": "我告诉过你，在我们找到安全的路之前，谁也不许动地图。",
    "arabic": "قلت لك: لا أحد يحرك الخرائط قبل أن نجد طريقا آمنا.",
}
MINUTES = 5
VOID = {"input", "link", "meta"}
"""Elements without an end."""


# Documents


def made(languages=2, characters=2):
    """A document of a project of realistic size, with invented numbers."""
    names, people = list(LANGUAGES)[:languages], list(CHARACTERS)[:characters]
    pairs = product(enumerate(names), enumerate(people))
    reports = [report(name, n, who, m) for (n, name), (m, who) in pairs]
    shared = [
        {"language": name, "phonemes": sounds(name)[21:], "bigrams": 43 * (len(sounds(name)) - 21)}
        for name in names
    ]
    return {
        "format": "lipsync-lang coverage 1",
        "corpus": {"files": ["act1.csv", "act2.csv", "barks.csv"], "lines": 1240, "words": 15302},
        "minutes": MINUTES,
        "reports": reports,
        "shared": shared,
        "later": "unknown keys are left alone",
    }


def sounds(language):
    return [*SOUNDS, "yu"] if language in {"mandarin", "french", "german"} else SOUNDS


def report(language, number, character, place):
    spoken, who = np.random.default_rng(number), np.random.default_rng([number, place])
    frequent = spoken.permutation(0.75 ** np.arange(len(sounds(language))) + 0.02)
    table = np.outer(frequent, frequent) * spoken.uniform(0.05, 1.5, (len(frequent),) * 2)
    pairs = [f"{a}-{b}" for a in sounds(language) for b in sounds(language)]
    counts = np.floor(table.ravel() / table.sum() * 42_000 * spoken.uniform(0.7, 1)).astype(int)
    order = [n for n in np.argsort(-counts, kind="stable") if counts[n]]
    rows = ranked([pairs[n] for n in order], counts[order], who, place * 0.22, language)
    unused = [pair for pair, heard in zip(pairs, counts, strict=True) if not heard]
    silent = [f"_-{a}" for a in sounds(language)] + [f"{a}-_" for a in sounds(language)]
    counts = np.sort(spoken.integers(1, 400, len(silent)))[::-1]
    silence = ranked(silent, counts, who, place * 0.2, language)
    total = sum(row["count"] for row in rows)
    drawn = [row for row in rows if row["status"] in {"edited", "approved"}]
    left = [row for row in rows if row not in drawn]
    phonemes = dict.fromkeys(sounds(language), 0)
    for row in rows:
        phonemes[row["bigram"].split("-")[0]] += row["count"]
    following = left[: 60 // MINUTES]
    text = LINES.get(language, LINES["english"])
    return {
        "language": language,
        "language_title": LANGUAGES[language],
        "character": character,
        "poseset": CHARACTERS[character],
        "lines": 1240,
        "words": 15302,
        "phonemes": phonemes,
        "occurrences": total,
        "bigrams": rows,
        "silence": silence,
        "unused": unused,
        "needed": {
            str(share): next((n for n, row in enumerate(rows, 1) if row["running"] >= share), 0)
            for share in (90, 95, 99, 100)
        },
        "authored": {"bigrams": len(drawn), "percent": share_of(drawn, total)},
        "left": {"bigrams": len(left), "hours": len(left) * MINUTES / 60},
        "next_hour": {
            "bigrams": [row["bigram"] for row in following],
            "percent": share_of(following, total),
        },
        "sentences": [
            {
                "place": f"act{1 + n % 2}.csv:{31 * n + 7}",
                "text": text,
                "bigrams": [row["bigram"] for row in left[9 * n : 9 * n + 9]],
            }
            for n in range(min(14, len(left) // 9 + 1))
        ],
        "unread": [
            {"what": f"{language}-zzyx", "count": 12, "place": "act1.csv:88"},
            {"what": "Qa'pla", "count": 3, "place": "barks.csv:4"},
        ],
        "unmapped": [{"what": "ʘ", "count": 2, "place": "act2.csv:19"}],
    }


def share_of(rows, total):
    return round(100 * sum(row["count"] for row in rows) / total, 2) if total else 0


def ranked(names, counts, who, drawn, language):
    total, running, rows = counts.sum(), 0, []
    for rank, (name, heard) in enumerate(zip(names, counts.tolist(), strict=True)):
        running += heard
        chance = who.random()
        layer, status = "draft", "drafted"
        if chance < drawn * 1.6 * (1 - rank / len(names)):
            layer = ["character", "language", "shared"][int(chance * 97) % 3]
            status = "approved" if int(chance * 1000) % 3 else "edited"
        elif "yu" in name:
            layer, status = "like", "drafted"
        elif chance > 0.985:
            layer = "gap"
            status = ""
        rows.append({
            "bigram": str(name), "count": heard, "percent": round(100 * heard / total, 3),
            "running": round(100 * running / total, 3), "layer": layer, "status": status,
            "example": f"{language[:4]}word{rank}",
            "places": [f"act{1 + n % 2}.csv:{(rank * 7 + n * 13) % 620}" for n in range(rank % 5)],
        })  # fmt: skip
    return rows


def empty_report():
    one = report("english", 0, "facefx", 0)
    return one | {
        "lines": 0, "words": 0, "phonemes": {}, "occurrences": 0, "bigrams": [], "silence": [],
        "unused": [], "needed": {"90": 0, "95": 0, "99": 0, "100": 0},
        "authored": {"bigrams": 0, "percent": 0}, "left": {"bigrams": 0, "hours": 0},
        "next_hour": {"bigrams": [], "percent": 0}, "sentences": [], "unread": [], "unmapped": [],
    }  # fmt: skip


def borrowed():
    """A pair whose last sound borrows from another sound with drawn curves."""
    one = report("english", 0, "facefx", 1)
    rows = [row | {"layer": "like", "status": "edited"} for row in one["bigrams"]]
    return one | {"bigrams": rows, "authored": {"bigrams": 0, "percent": 0}}


def whole(*reports):
    return made(1, 1) | {"reports": list(reports)}


EMPTY = {
    "no reports": made(1, 1) | {"reports": [], "shared": []},
    "no bigrams": whole(empty_report()),
    "no lines at all": whole(empty_report())
    | {"corpus": {"files": [], "lines": 0, "words": 0}, "shared": []},
}
MADE = {"one": made(1, 1), "some": made(3, 3), "lent": whole(borrowed()), **EMPTY}
every_document = pytest.mark.parametrize("document", swept(MADE.values(), quick=3), ids=MADE)


# Reading pages


class Element:
    def __init__(self, name, attributes, parent=None):
        self.name, self.attributes, self.parent = name, attributes, parent
        self.children = []

    def all(self, name=None, **attributes):
        """Yield the elements below, in order, that have a name and attributes."""
        wanted = {key.rstrip("_").replace("_", "-"): value for key, value in attributes.items()}
        for child in self.children:
            if isinstance(child, Element):
                if name in (None, child.name) and wanted.items() <= child.attributes.items():
                    yield child
                yield from child.all(name, **attributes)

    def one(self, name=None, **attributes):
        (found,) = self.all(name, **attributes)
        return found

    @property
    def text(self):
        return "".join(one.text if isinstance(one, Element) else one for one in self.children)


class Reader(HTMLParser):
    """Builds the tree of a page, and fails if an element is not closed."""

    def __init__(self, content):
        super().__init__()
        self.root = self.here = Element("", {})
        self.feed(content)
        self.close()
        assert self.here is self.root, f"<{self.here.name}> is not closed"

    def handle_starttag(self, tag, attrs):
        assert len(attrs) == len(dict(attrs)), f"<{tag}> has an attribute twice"
        element = Element(tag, dict(attrs), self.here)
        self.here.children.append(element)
        if tag not in VOID:
            self.here = element

    def handle_endtag(self, tag):
        assert self.here.name == tag, f"</{tag}> within <{self.here.name}>"
        self.here = self.here.parent

    def handle_data(self, data):
        self.here.children.append(data)


def read(document):
    """Parse the page of a document; the same document is not parsed twice."""
    return parsed(json.dumps(document))


@cache
def parsed(text):
    return Reader(page(json.loads(text))).root


class Shown:
    """Text of the page for a report, as composed by its script."""

    def __init__(self, root, number):
        picker = root.one("select", id="picker")
        option = root.one("option", value=str(number))
        stored = {
            one.attributes["data-key"]: one for one in root.all() if "data-key" in one.attributes
        }
        names = picker.attributes["data-parts"].split()
        keys = option.attributes["data-keys"].split()
        self.parts = {name: stored[key] for name, key in zip(names, keys, strict=True)}
        words = root.one("nav", class_="picker").attributes
        self.statuses, self.layers = words["data-statuses"].split(), words["data-layers"].split()
        self.title = option.text
        self.states = {
            part: self._states(option.attributes[f"data-{part}"]) for part in ("ranked", "silence")
        }

    def _states(self, codes):
        """Return (status, layer) of each bigram."""
        statuses, layers = codes.split(" ")
        return [
            (self.statuses[int(status, 36)], self.layers[int(layer, 36)])
            for status, layer in zip(statuses, layers, strict=True)
        ]

    def rows(self, part):
        rows = self.parts[part].all("tr")
        return [[one.text for one in row.children] for row in rows]


# What must hold of every page


@every_document
def test_every_element_is_closed_and_every_name_is_the_only_one(document):
    root = read(document)
    names = [one.attributes["id"] for one in root.all() if "id" in one.attributes]
    assert len(names) == len(set(names))
    assert [one.name for one in root.children if isinstance(one, Element)] == ["html"]


@every_document
def test_the_same_document_gives_the_same_page(document):
    assert page(document) == page(json.loads(json.dumps(document)))


@every_document
def test_the_page_asks_nobody_for_anything(document):
    content = page(document)
    assert not re.search(r"https?:|//\w|@import|url\(|\bsrc=|<iframe|<object|<embed", content)
    assert re.findall(r'href="([^"]*)"', content) == ["data:,"]
    root = Reader(content).root
    policy = next(
        one.attributes["content"] for one in root.all("meta")
        if one.attributes.get("http-equiv") == "Content-Security-Policy"
    )  # fmt: skip
    digest = b64encode(sha256(root.one("script").text.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy


@every_document
def test_headings_go_down_a_step_at_a_time_and_every_picture_has_words(document):
    root = read(document)
    levels = [
        int(one.name[1]) for one in root.one("main").all() if re.fullmatch("h[1-6]", one.name)
    ]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(low <= high + 1 for high, low in pairwise(levels))
    assert all(one.attributes["aria-label"] for one in root.all(role="img"))


# What it tells


def facts(one):
    """Yield the texts that the parts of a report must contain, with the part."""
    yield "summary", percentage_text(one["authored"]["percent"], NBSP)
    yield "summary", hours(one["left"]["hours"])
    yield "summary", count(one["left"]["bigrams"], "bigram", space=NBSP)
    yield from (("summary", f"{number:,}") for number in one["needed"].values())
    yield "summary", count(one["occurrences"], "bigram", space=NBSP)
    yield from (("next", name) for name in one["next_hour"]["bigrams"])
    yield "next", percentage_text(one["next_hour"]["percent"], NBSP)
    yield from (("phonemes", f"{name}{number:,}") for name, number in one["phonemes"].items())
    yield from (("unused", name) for name in one["unused"])
    for sentence in one["sentences"]:
        yield from (("sentences", text) for text in (sentence["text"], sentence["place"]))
        yield from (("sentences", name) for name in sentence["bigrams"])
    for unknown in (*one["unread"], *one["unmapped"]):
        yield "unread", f"{unknown['what']}{unknown['count']}{unknown['place']}"


@pytest.mark.parametrize("number", swept(range(9), quick=3))
def test_every_fact_of_every_report_is_there(number):
    document = MADE["some"]
    one = document["reports"][number]
    shown = Shown(read(document), number)
    assert shown.title == f"{one['language_title']} on {one['character']}"
    texts = {name: part.text for name, part in shown.parts.items()}
    assert not [(part, fact) for part, fact in facts(one) if fact not in texts[part]]
    for part, rows in (("ranked", one["bigrams"]), ("silence", one["silence"])):
        told = shown.rows(part)
        assert len(told) == len(rows)
        for rank, (cells, row) in enumerate(zip(told, rows, strict=True), 1):
            numbers = (f"{row['count']:,}", f"{row['percent']:.2f}", f"{row['running']:.2f}")
            assert cells[:5] == [str(rank), row["bigram"], *numbers]
            assert cells[7] == row["example"]
            assert cells[8] == gathered(row["places"][:3])
        states = [(row["status"] or "gap", row["layer"]) for row in rows]
        assert shown.states[part] == states


def test_the_map_has_each_bigram_where_its_sounds_meet():
    document = MADE["some"]
    head, *lines = Shown(read(document), 6).parts["map"].all("tr")
    seconds = [cell.text for cell in head.children[1:]]
    found = {}
    for line in lines:
        first, *cells = line.children
        places = [cell.attributes.get("data-i") for cell in cells]
        found |= {f"{first.text}-{b}": int(i) for b, i in zip(seconds, places, strict=True) if i}
    rows = document["reports"][6]["bigrams"]
    assert found == {row["bigram"]: number for number, row in enumerate(rows)}


def test_the_first_report_can_be_read_without_scripts():
    document = MADE["some"]
    one, root = document["reports"][0], read(document)
    parts = [one for one in root.all() if "data-part" in one.attributes]
    visible = {part.attributes["data-part"]: part for part in parts}
    assert not [(part, fact) for part, fact in facts(one) if fact not in visible[part].text]
    states = [[cell.text for cell in row.children[5:7]] for row in visible["ranked"].all("tr")]
    assert states == [[row["status"] or "gap", row["layer"]] for row in one["bigrams"]]
    assert "English on facefx" in root.one("noscript").text


def test_what_needs_the_script_is_hidden_until_it_runs():
    root = read(MADE["some"])
    controls = [one for one in root.one("main").all() if one.name in {"button", "input", "select"}]
    assert controls
    for control in controls:
        above = control
        while above and "hidden" not in above.attributes:
            above = above.parent
        assert above, f"<{control.name}> is dead without a script"


def test_the_matrix_has_every_pair():
    document = MADE["some"]
    cells = [
        one for one in read(document).one(id="matrix").all("td") if "data-report" in one.attributes
    ]
    assert [int(cell.attributes["data-report"]) for cell in cells] == list(range(9))
    for cell, one in zip(cells, document["reports"], strict=True):
        assert percentage_text(one["authored"]["percent"], NBSP) in cell.text
        assert f"{hours(one['left']['hours'])} left" in cell.text


@full
def test_no_report_hides_another_in_the_matrix():
    one = report("english", 0, "facefx", 0)
    other = report("english", 1, "facefx", 1)
    columns = [one | {"column": "en"}, other | {"column": "en-gb"}]
    matrix = read(whole(one, other, *columns)).one(id="matrix")
    cells = [cell for cell in matrix.all("td") if "data-report" in cell.attributes]
    assert [cell.attributes["data-report"] for cell in cells] == ["0", "1", "2", "3"]
    rows = [row.one("th").text for row in matrix.one("tbody").all("tr")]
    assert rows == ["English", "English", "English (en)", "English (en-gb)"]
    assert Shown(read(whole(*columns)), 1).title == "English (en-gb) on facefx"


def test_words_in_another_script_are_listed_by_whether_they_count():
    words = [
        {"what": "会議", "count": 3, "place": "a.csv:7", "script": "CJK", "counted": False},
        {"what": "hello", "count": 2, "place": "a.csv:9", "script": "LATIN", "counted": True},
    ]
    shown = Shown(read(whole(report("english", 0, "facefx", 0) | {"other_scripts": words})), 0)
    told = shown.parts["unread"].text
    lists = told.partition("Other scripts, not counted")[2].split("Other scripts, read")
    assert ["会議3a.csv:7" in each for each in lists] == [True, False]
    assert ["hello2a.csv:9" in each for each in lists] == [False, True]


def test_the_top_says_what_to_do_next():
    header = read(MADE["some"]).one("header")
    best = max(
        MADE["some"]["reports"], key=lambda one: one["next_hour"]["percent"] * one["occurrences"]
    )
    share = percentage_text(best["next_hour"]["percent"], NBSP)
    assert f"Draw these 12 bigrams next: they are {share}" in header.text
    assert all(name in header.text for name in best["next_hour"]["bigrams"])
    assert "English and Spanish add nothing; Mandarin adds 43\xa0bigrams with yu." in header.text


def test_what_is_done_is_said_to_be_done():
    one = report("english", 0, "facefx", 1)
    done = one | {"next_hour": {"bigrams": [], "percent": 0}, "left": {"bigrams": 0, "hours": 0}}
    root = read(whole(done))
    assert "Nothing is left to draw for English on facefx." in root.one("header").text
    assert "done" in root.one(id="matrix").text


def test_what_is_lent_by_another_sound_is_not_called_drawn():
    shown = Shown(read(MADE["lent"]), 0)
    assert {status for status, _ in shown.states["ranked"]} == {"borrowed"}


def test_states_that_nobody_foresaw_are_shown_by_their_names():
    one = report("english", 0, "facefx", 0)
    rows = [row | {"layer": "dream", "status": "guessed"} for row in one["bigrams"]]
    shown = Shown(read(whole(one | {"bigrams": rows})), 0)
    assert set(shown.states["ranked"]) == {("guessed", "dream")}
    assert "guessed" in shown.parts["summary"].text


@pytest.mark.parametrize("document", EMPTY.values(), ids=EMPTY)
def test_a_page_of_nothing_says_so(document):
    root = read(document)
    lead = root.one("p", class_="lead").text
    assert re.search("No language|The script has no line", lead)
    assert "nan" not in root.one("main").text.lower()


def test_every_report_of_equal_figures_has_its_own_number():
    document = whole(empty_report())
    document["reports"] = document["reports"] * 3
    cells = read(document).one("section", id="matrix").all("td")
    numbers = [cell.attributes["data-report"] for cell in cells if "data-report" in cell.attributes]
    assert numbers == ["0", "1", "2"]


def test_places_leave_out_the_folder_that_all_files_are_in():
    document = json.loads(json.dumps(made(1, 1)).replace('"act', '"/project/lines/act'))
    document["corpus"]["files"][2] = "/project/lines/barks.csv"
    text = read(document).one("main").text
    assert "/project" not in text
    assert "act1.csv, act2.csv and barks.csv" in text


# Safety

NASTY = [
    "<script>alert(1)</script>", "</script><img src=x onerror=alert(1)>", "</template><b>", "<!--",
    "\"'><svg onload=alert(1)>", "&lt;b&gt;", "]]>", "</style>", "{{x}} $title ${body}",
]  # fmt: skip
NAMES = {"format", "layer", "status"}


def spoiled(value, text):
    """Insert a text into every string of a document except the names of states."""
    if isinstance(value, dict):
        return {key: one if key in NAMES else spoiled(one, text) for key, one in value.items()}
    if isinstance(value, list):
        return [spoiled(one, text) for one in value]
    return f"{value}{text}" if isinstance(value, str) else value


@full
@pytest.mark.parametrize("text", swept(NASTY, quick=1))
def test_no_text_of_a_corpus_becomes_markup(text):
    document = made(2, 2)
    root, sound = read(spoiled(document, text)), read(spoiled(document, "harmless"))

    def names(tree):
        return sorted(one.name for one in tree.all())

    assert names(root) == names(sound)
    assert root.one("script").text == sound.one("script").text
    assert text in Shown(root, 3).parts["sentences"].text
    assert text in root.one("p", class_="eyebrow").text


# Size


@full
def test_ten_languages_on_five_characters_stay_small():
    document = made(10, 5)
    content = page(document)
    assert len(content.encode()) < 2_200_000
    stored = [one for one in Reader(content).root.all() if "data-key" in one.attributes]
    rankings = [one for one in stored if len(list(one.all("tr"))) > 300]
    assert len(rankings) == 10, "a language's ranking is written once"


# Words


@pytest.mark.parametrize(
    ("share", "text"),
    [(0, "0 %"), (0.0001, "under 0.1 %"), (0.98, "1.0 %"), (9.94, "9.9 %"), (27.9, "27.9 %"),
     (31, "31.0 %"), (99.94, "99.9 %"), (99.9999, "99.9 %"), (100, "100 %")],
)  # fmt: skip
def test_shares_are_written_by_one_rule(share, text):
    assert percentage_text(share) == text
    assert percentage_text(share, NBSP) == text.replace(" %", "\xa0%")


@given(st.integers(0, 10**9), st.integers(1, 10**9))
def test_all_is_a_hundred_percent_and_nothing_else_is(part, whole):
    part = min(part, whole)
    share = percent(part, whole)
    assert (share == 100, share == 0) == (part == whole, part == 0)
    assert share == pytest.approx(100 * part / whole, abs=1e-4)
    assert (percentage_text(share) == "100 %") == (part == whole)
    assert (percentage_text(share) == "0 %") == (part == 0)


@pytest.mark.parametrize(
    ("time", "text"),
    [(0, "0 min"), (5 / 12, "25 min"), (1, "1 h"), (3.52, "3.5 h"), (28.58, "29 h"),
     (1234, "1,234 h")],
)  # fmt: skip
def test_times_are_what_a_plan_says(time, text):
    assert hours(time).replace("\xa0", " ") == text


def test_lists_read_like_sentences():
    assert listed([]) == "none"
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert listed(["a", "b", "c", "d", "e"]) == "a, b, c and 2 more"
    assert gathered(["a.csv:3", "b:c.csv:5", "a.csv:17"]) == "a.csv:3, 17; b:c.csv:5"
    assert folder(["/a/bc/d.txt", "/a/bd/e.txt"]) == "/a/"
    assert folder(["c:\\a\\b.txt"]) == "c:\\a\\"
    assert folder(["a.txt", "b.txt"]) == folder([]) == ""
