"""JSON: the whole document; its schema is `docs/reference/coverage.schema.json`."""

import json
from typing import TYPE_CHECKING, TextIO

from lipsync_lang.reports.coverage.forms import FORMS, FormOptions

if TYPE_CHECKING:
    from lipsync_lang.reports.coverage.report import Coverage


@FORMS.register("json")
def write(coverage: "Coverage", out: TextIO, options: FormOptions) -> None:
    """Write the document."""
    del options  # it is always whole
    # Standard output of Windows may hold no IPA, which JSON can escape.
    holds_all = (getattr(out, "encoding", None) or "utf-8").lower().startswith("utf")
    json.dump(coverage.to_dict(), out, ensure_ascii=not holds_all, indent=2)
    out.write("\n")
