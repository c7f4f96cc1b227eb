"""Printer of the JSON Schema of a coverage document, for `docs/reference/coverage.schema.json`.

python -m lipsync_lang.coverage.document_schema > docs/reference/coverage.schema.json
"""

import json
import sys

from lipsync_lang.coverage.report import schema


def written() -> str:
    """Return the text of the schema file."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(written())
