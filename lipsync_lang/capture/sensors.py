"""Sensors: tables of positions, converted to measures of a pose set by a read-out.

Conventions: T samples, M measures; times are in seconds.
"""

from pathlib import Path
from typing import NamedTuple, cast

import numpy as np

from lipsync_lang.animations.animation_readers import (
    LONGEST_SECONDS,
    MAX_ANIMATION_BYTES,
    MAX_VALUE,
    MIN_FRAMES,
    fail,
)
from lipsync_lang.animations.readers.csv import table_of
from lipsync_lang.arrays import Floats
from lipsync_lang.errors import AnimationError, did_you_mean
from lipsync_lang.files import read_input
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import ReadOut


class SensorSignals(NamedTuple):
    """Measures from a table of sensors."""

    times: Floats
    """(T,) seconds."""
    measures: tuple[str, ...]
    values: Floats
    """(T, M) values; NaN for a lost sensor."""
    remarks: tuple[str, ...]


def load_readout(path: Path) -> ReadOut:
    """Read a read-out.

    Raises
    ------
    PackFaults
        The file is unsound; the error has all its faults.
    """
    return cast("ReadOut", Library(project=None).load(path, "readout").model)


def read_sensors(path: Path, readout: ReadOut) -> SensorSignals | None:
    """Read a table of sensors; return None without any column of the read-out.

    Raises
    ------
    AnimationError
        The file is not a table of numbers with rising times, or lacks some of the columns of every
        measure.
    """
    content = read_input(
        path, MAX_ANIMATION_BYTES, error=AnimationError, mend="check that it is a table of sensors"
    )
    times, names, table = table_of(path, content, gaps=True)
    wanted = {column for sums in readout.measures.values() for column in sums}
    if wanted.isdisjoint(names):
        return None
    _check_times(path, times)
    lacking = {
        measure: column
        for measure, sums in readout.measures.items()
        for column in sums
        if column not in names
    }
    known = [measure for measure in readout.measures if measure not in lacking]
    if not known:
        column = min(wanted - set(names))
        fail(path, f"has no column '{column}'", did_you_mean(column, names))
    remarks = [
        f"{path}: has no column '{column}', so measure '{measure}' is left out"
        for measure, column in lacking.items()
    ]
    sensed = np.where(np.isfinite(table), table, np.nan)
    if readout.lost is not None:
        sensed[sensed == readout.lost] = np.nan
    beyond = (np.abs(sensed) > MAX_VALUE).any(axis=1)
    if beyond.any():
        what = f"sample {int(beyond.argmax())}: a value is beyond {MAX_VALUE:g}"
        fail(path, what, "state such values as `lost` in the read-out, or export the table again")
    places = {name: at for at, name in enumerate(names)}
    values = np.column_stack(
        [
            sum(
                weight * sensed[:, places[column]]
                for column, weight in readout.measures[one].items()
            )
            for one in known
        ]
    )
    return SensorSignals(times, tuple(known), values, tuple(remarks))


def _check_times(path: Path, times: Floats) -> None:
    if len(times) < MIN_FRAMES:
        fail(path, f"has only {len(times)} samples", "export the whole recording")
    if not (np.isfinite(times) & (np.abs(times) <= LONGEST_SECONDS)).all():
        fail(
            path,
            "a time is not a number of seconds",
            "name the column time_ms if it has milliseconds",
        )
    falls = np.diff(times) <= 0
    if falls.any():
        fail(path, f"sample {int(falls.argmax()) + 1}: its time does not rise", "sort the table")
