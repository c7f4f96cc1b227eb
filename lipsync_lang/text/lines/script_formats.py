"""Formats of scripts in JSON and XML that differ in their paths and names alone."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lipsync_lang.text.lines.json_scripts import JsonScript, add_json_script
from lipsync_lang.text.lines.line_readers import LINE_READERS
from lipsync_lang.text.lines.xml_scripts import XML_SCRIPTS, XmlScript


def add_script(name: str, fields: Mapping[str, Any], module: str) -> None:
    """Register a format of scripts by its fields: in XML if it states `entries`, else in JSON."""
    if "entries" in fields:
        XML_SCRIPTS[name] = XmlScript(name, **fields)
        LINE_READERS.add(name, XML_SCRIPTS[name].reader(), module)
    else:
        add_json_script(JsonScript(name, **fields), module)


for _name, _fields in json.loads(Path(__file__).with_suffix(".json").read_text("utf-8")).items():
    add_script(_name, _fields, __name__)
