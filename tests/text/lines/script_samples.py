"""Files of scripts for translation and of engines, which the fuzz tests damage, and their lines."""

from pathlib import Path

from lipsync_lang.text.lines.line_readers import LINE_READERS

SEEDS = Path(__file__).parents[2] / "fuzz" / "seeds" / "lines"

LINES = {
    "xliff/1.xlf": [
        (5, "greet", "Anna", "Hallo, !"),
        (7, "maps-one", "", "Karte"),
        (7, "maps-other", "", "Karten"),
    ],
    "xliff/2.xliff": [
        (1, "greet", "Bo", "Bonjour."),
        (1, "greet-1", "Bo", "Va,."),
    ],
    "android-strings/1.xml": [
        (3, "hi", "", "Don't go, !"),
        (4, "maps-one", "", "map"),
        (4, "maps-other", "", "maps"),
        (5, "days", "", "Monday"),
        (5, "days-1", "", "Tuesday!"),
    ],
    "resx/1.resx": [
        (2, "Hi", "Anna", "Hello, !"),
    ],
    "arb/1.arb": [
        (1, "greet", "", "Hallo, !"),
        (1, "n-0", "", "Keine Karten"),
        (1, "n-one", "", "Eine Karte"),
        (1, "n-other", "", "Karten"),
    ],
    "xcstrings/1.xcstrings": [
        (1, "Hello", "", "Hello"),
        (1, "maps %lld", "", "maps"),
    ],
    "unreal-archive/1.archive": [
        (1, "Game,A1", "", "Hallo"),
    ],
    "unreal-manifest/1.manifest": [
        (1, "A1", "", "Hello"),
    ],
    "json-tree/1.json": [
        (3, "menu.greet", "", "Hello, !"),
        (4, "menu.maps_one", "", "map"),
        (5, "menu.maps_other", "", "maps"),
        (7, "list.0", "", "One."),
        (7, "list.1", "", "Two."),
    ],
    "json-tree/2.json": [
        (1, "en.a", "", "Hello."),
        (1, "de.a", "", "Hallo."),
    ],
    "chrome-messages/1.json": [
        (1, "greet", "Bo", "Hello"),
    ],
    "fluent/1.ftl": [
        (2, "hello", "Anna", "Hello, ! Nice day at Mapland."),
        (5, "maps-one", "", "One map."),
        (5, "maps-other", "", "maps."),
        (10, "button", "", "Go"),
        (11, "button.label", "", 'Press "me"'),
    ],
    "strings/1.strings": [
        (2, "greet", "Bo", 'Hello, ! "Yes" no'),
        (4, "bye", "", "Bye é."),
    ],
    "stringsdict/1.stringsdict": [
        (4, "maps-one", "", "I have one map."),
        (4, "maps-other", "", "I have maps."),
    ],
    "twee/1.twee": [
        (5, "Hall-of-Maps-1", "Anna", "Hello,."),
        (6, "Hall-of-Maps-2", "", "You see a map."),
        (7, "Hall-of-Maps-3", "", "Go on."),
        (8, "Hall-of-Maps-4", "", "Hall two"),
    ],
    "rails/1.yml": [
        (3, "menu.greet", "", "Hallo, !"),
        (5, "menu.maps.one", "", "Eine Karte"),
        (6, "menu.maps.other", "", "Karten"),
        (7, "menu.days.0", "", "Montag"),
        (7, "menu.days.1", "", "Dienstag"),
    ],
    "rpg-maker/1.json": [
        (3, "1.1.0.0", "Harold", "Hello,. You have maps."),
        (3, "1.1.0.3-0", "", "Yes"),
        (3, "1.1.0.3-1", "", "No"),
        (3, "1.1.0.6", "", "Long ago."),
    ],
    "rpg-maker/2.json": [
        (3, "2.1.0", "", "Boom."),
    ],
    "formatjs/1.json": [
        (1, "greet", "Bo", "Hello, !"),
    ],
}
"""(place, name, speaker, text) of each line, by seed."""

LINES = {seed: lines for seed, lines in LINES.items() if seed.partition("/")[0] in LINE_READERS}

FILES = {Path(seed).suffix: ((SEEDS / seed).read_text("utf-8"), LINES[seed]) for seed in LINES}
FILES |= {".resw": FILES[".resx"]} | ({".tw": FILES[".twee"]} if ".twee" in FILES else {})
"""Text and lines of one file of each suffix."""
