#!/usr/bin/env bash
# Jouvence 0.4.2 (Apache-2.0), fountain-py 0.3.0 (MIT) and fountain-tools 0.0.7 (MIT), readers of screenplays in
# Fountain, seen on 2026-11-30; beside them fountain-parser 0.1.1 and, from npm, fountain-js 1.2.4.
#
# Behaviour: a line in capitals after an empty one names a character, and what follows it is said. Three of five readers
# know the capitals from A to Z alone: the lines of `ÉMILE`, `ИВАН` and `ΕΛΈΝΗ` become action, which nobody says. For two
# of them one letter within a name is enough (`ZOË`). Jouvence loses names with a digit or an apostrophe, too.
#
# What a good engineer expects: the format asks for upper case, and Unicode says which letters are.
# What to do: write `@` before each name, which all five take; and count the speakers of a script against its cast.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check \
  jouvence==0.4.2 fountain-py==0.3.0 fountain-tools==0.0.7 fountain-parser==0.1.1
npm init --yes > /dev/null
npm install --silent --no-audit --no-fund fountain-js@1.2.4
cat > names.json <<'JSON'
["ALICE", "R2D2", "O'NEIL", "ZOË", "ÉMILE", "ИВАН", "ΕΛΈΝΗ", "@ÉMILE", "@ИВАН"]
JSON
cat > read.py <<'PYTHON'
import json
from pathlib import Path

import fountain
import fountain_parser
from fountain_tools.parser import Parser
from jouvence.parser import JouvenceParser


def by_fountain_py(script):
    elements = fountain.FountainParser().parse(script).elements
    return [one.text for one in elements if one.type.name == "DIALOGUE"]


def by_fountain_tools(script):
    parser = Parser()
    parser.add_text(script)
    return [one.text for one in parser.script.elements if one.type.name == "DIALOGUE"]


def by_fountain_parser(script):
    scenes = fountain_parser.parse(script).scenes
    return [one.text for scene in scenes for one in scene.elements if isinstance(one, fountain_parser.Dialogue)]


def by_jouvence(script):
    scenes = JouvenceParser().parseString(script).scenes
    return [one.text for scene in scenes for one in scene.paragraphs if one.type == 3]  # 3: dialogue


for name in json.loads(Path("names.json").read_text(encoding="utf-8")):
    script = f"INT. HARBOUR - DAY\n\n{name}\nGood morning.\n"
    said = {
        read.__name__.removeprefix("by_"): read(script) == ["Good morning."]
        for read in (by_fountain_parser, by_fountain_py, by_fountain_tools, by_jouvence)
    }
    print(name, "is lost by", ", ".join(reader for reader, spoken in said.items() if not spoken) or "none")
PYTHON
cat > read.mjs <<'SCRIPT'
import { readFileSync } from "node:fs";
import { Fountain } from "fountain-js";

const said = JSON.parse(readFileSync("names.json", "utf-8")).filter((name) => {
  const { tokens } = new Fountain().parse(`INT. HARBOUR - DAY\n\n${name}\nGood morning.\n`, true);
  return tokens.some(({ type, text }) => type === "dialogue" && text === "Good morning.");
});
console.log(`fountain-js: ${said.join(", ")}`);
SCRIPT
{ env/bin/python -W ignore read.py; node read.mjs; } > seen 2> errors || { cat errors >&2; exit 1; }
diff seen - <<'SEEN'
ALICE is lost by none
R2D2 is lost by jouvence
O'NEIL is lost by jouvence
ZOË is lost by fountain_py, jouvence
ÉMILE is lost by fountain_py, fountain_tools, jouvence
ИВАН is lost by fountain_py, fountain_tools, jouvence
ΕΛΈΝΗ is lost by fountain_py, fountain_tools, jouvence
@ÉMILE is lost by none
@ИВАН is lost by none
fountain-js: ALICE, R2D2, O'NEIL, ZOË, ÉMILE, ИВАН, ΕΛΈΝΗ, @ÉMILE, @ИВАН
SEEN
echo "as before: three readers of Fountain take the lines of names beyond A to Z as action"
