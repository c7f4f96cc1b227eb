"""Formats of scripts in JSON and XML that differ in their paths and names alone.

`script_formats.json` states them by name, in the fields of `JsonScript`, or of `XmlScript` where
there are `entries`.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lipsync_lang.text.lines.json_scripts import JsonScript, add_json_script
from lipsync_lang.text.lines.xml_scripts import XmlScript, add_xml_script


def add_script(name: str, row: Mapping[str, Any], module: str) -> None:
    """Register a format of scripts in XML or JSON."""
    fields = {**row} | {one: tuple(value) for one, value in row.items() if isinstance(value, list)}
    if "entries" in fields:
        add_xml_script(XmlScript(name, **fields), module)
    else:
        add_json_script(JsonScript(name, **fields), module)


for _name, _row in json.loads(Path(__file__).with_suffix(".json").read_text("utf-8")).items():
    add_script(_name, _row, __name__)
