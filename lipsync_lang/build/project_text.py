"""The text of a drafted `lipsync.yaml`, with comments for what can be added."""

import json
import re
from typing import NamedTuple

SHOWN_SPEAKERS = 20

PLAIN_SCALAR = re.compile(r"[A-Za-z][\w./-]*(?<![.])")
"""Text that means itself in YAML without quotes; words such as `no` are quoted by `flow`."""

YAML_WORDS = {"y", "n", "yes", "no", "on", "off", "true", "false", "null"}
"""Plain words that YAML takes for other things."""

TEXT = """\
# `lipsync-lang build` makes all lines of this script, and after that only what changed.
kind: project
format: 1

# The script; each row is a line.
lines: {lines}
columns: {columns}
languages: {languages}

# The recording of a line. A voice speaks the lines that have none. Timed phonemes beside it, such
# as a TextGrid, are found by themselves; state `timings: ...` for those in another folder.
{audio}

# The characters of each speaker; "*" is everybody else.
cast: {cast}{speakers}

# The files of each line; the suffix names the format (`lipsync-lang formats`).
outputs: {outputs}

# Limits that fail a build (`lipsync-lang check`), and what is written about it:
# limits: {{contacts: 0, speed: 12, confidence: 0.4}}
reports: build/report.html
"""


class ProjectLayout(NamedTuple):
    """Contents of a drafted project."""

    lines: str
    audio: str | None
    columns: dict[str, str]
    languages: dict[str, str]
    characters: list[str]
    speakers: list[str]


def project_text(layout: ProjectLayout) -> str:
    """Return the text of a project file, with comments for what can be added."""
    same = all(name == word for name, word in layout.languages.items())
    languages = list(layout.languages) if same else layout.languages
    several = "{language}/" if len(layout.languages) > 1 else ""
    cast = {"*": layout.characters[0] if len(layout.characters) == 1 else layout.characters}
    speakers = "".join(
        f"\n#   {json.dumps(one, ensure_ascii=False)}: ..."
        for one in layout.speakers[:SHOWN_SPEAKERS]
    )
    recorded = flow(f"vo/{several}{{id}}.wav")
    return TEXT.format(
        lines=flow(layout.lines), columns=flow(layout.columns), languages=flow(languages),
        audio=f"audio: {flow(layout.audio)}" if layout.audio else f"# audio: {recorded}",
        cast=flow(cast),
        speakers=f"\n# Speakers of their own go beside it:{speakers}" if speakers else "",
        outputs=flow(f"takes/{several}{{character}}/{{id}}.csv"),
    )  # fmt: skip


def flow(value: object) -> str:
    """Return a value as YAML on one line; JSON is YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{flow(key)}: {flow(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    text = str(value)
    return (
        text
        if PLAIN_SCALAR.fullmatch(text) and text.lower() not in YAML_WORDS
        else json.dumps(text, ensure_ascii=False)
    )
