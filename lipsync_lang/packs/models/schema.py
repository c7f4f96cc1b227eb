"""JSON Schemas of packs, for completion and checks in text editors."""

from typing import Any

from lipsync_lang.base.errors import PackError, did_you_mean
from lipsync_lang.packs.models import MODELS

DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The dialect of the schemas."""


def kinds() -> list[str]:
    """List the kinds of packs."""
    return sorted(MODELS)


def schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of pack; raise `PackError` for an unknown kind."""
    if kind not in MODELS:
        raise PackError(f"unknown kind of pack '{kind}': {did_you_mean(kind, MODELS)}")
    made = MODELS[kind].model_json_schema(by_alias=True, mode="validation")
    return {"$schema": DIALECT, **made}
