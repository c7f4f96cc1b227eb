"""The type of JSON objects that are read from files or written to them."""

from typing import Any

Json = dict[str, Any]
"""A JSON object, as `json` loads it: its form is checked where it is read."""
