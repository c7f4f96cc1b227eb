"""Figures of a benchmark as a JSON file, for `docs/measure.py` and whoever else reads them."""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

DIGITS = 5
"""Decimal places that are kept."""

WITHIN_MS = (2.5, 5, 7.5, 10, 15, 20, 25, 30, 40, 50, 75, 100, 150, 200)
"""Errors of boundaries whose shares are kept."""


def add_option(parser: argparse.ArgumentParser) -> None:
    """Add `--json FILE`."""
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures as JSON too")


def write_figures(file: Path | None, figures: Mapping[str, Any]) -> None:
    """Write figures, if a file was named."""
    if file is not None:
        text = json.dumps(_plain(figures), indent=1, ensure_ascii=False, allow_nan=False)
        file.write_text(text + "\n", encoding="utf-8")


def _plain(value: Any) -> Any:
    """Return numbers as Python's own, rounded; keys as text."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(one) for one in value]
    if isinstance(value, bool | str | None):
        return value
    return int(value) if isinstance(value, int | np.integer) else round(float(value), DIGITS)


def boundary_errors(late: Sequence[float]) -> dict[str, Any]:
    """Summarise boundaries that come late by so many seconds; early ones are negative."""
    far = np.abs(late) * 1000
    return {
        "boundaries": len(far),
        "median_ms": np.median(far),
        "mean_ms": np.mean(far),
        "p90_ms": np.quantile(far, 0.9),
        "late_ms": np.median(late) * 1000,
        "within_ms": {f"{limit:g}": np.mean(far <= limit) for limit in WITHIN_MS},
    }
