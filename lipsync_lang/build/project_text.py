"""The text of a drafted `lipsync.yaml`, with comments for what can be added."""

import json
from typing import NamedTuple

from lipsync_lang.packs.yaml.value_text import on_one_line

SHOWN_SPEAKERS = 20

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
    recorded = on_one_line(f"vo/{several}{{id}}.wav")
    return TEXT.format(
        lines=on_one_line(layout.lines), columns=on_one_line(layout.columns),
        languages=on_one_line(languages),
        audio=f"audio: {on_one_line(layout.audio)}" if layout.audio else f"# audio: {recorded}",
        cast=on_one_line(cast),
        speakers=f"\n# Speakers of their own go beside it:{speakers}" if speakers else "",
        outputs=on_one_line(f"takes/{several}{{character}}/{{id}}.csv"),
    )  # fmt: skip
