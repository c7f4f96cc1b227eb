"""Formats of scripts in JSON and XML that differ in their paths and names alone.

`script_formats.json` states them by name, in the fields of `JsonScript`, or of `XmlScript` where
there are `entries`.
"""

import json
from pathlib import Path
from typing import Any

from lipsync_lang.text.lines.json_scripts import JsonScript, add_json_script
from lipsync_lang.text.lines.xml_scripts import XmlScript, add_xml_script

_stated: dict[str, dict[str, Any]]
_stated = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
for name, row in _stated.items():
    lists = {one: tuple(value) for one, value in row.items() if isinstance(value, list)}
    fields = row | lists
    if "entries" in fields:
        add_xml_script(XmlScript(name, **fields), __name__)
    else:
        add_json_script(JsonScript(name, **fields), __name__)
