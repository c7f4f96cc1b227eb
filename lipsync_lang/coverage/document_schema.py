"""The JSON Schema of a coverage, as `docs/reference/coverage.schema.json` has it.

python -m lipsync_lang.coverage.document_schema > docs/reference/coverage.schema.json
"""

import json
import sys

from lipsync_lang.coverage.report import schema


def written() -> str:
    """Return the schema as its file holds it."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(written())
