"""A whole game on paper: hours, disk and memory from measured figures."""

from collections.abc import Iterator, Sequence

from speed_table import Row

LINES, LANGUAGES, CHARACTERS = 50_000, 12, 30
TAKES = LINES * LANGUAGES * CHARACTERS
CHANGED = 200
"""Lines that change in a day, in all languages and on all characters."""

MACHINES = 10

WAYS = {"CSV and GLB": "cold, 2 workers", "CSV alone": "CSV alone, cold, 2 workers"}
SIZES = {"CSV": "csv for each line", "GLB": "glb for each line"}
PACKED = "csv in an archive, for each line"
RECORD = "build.sqlite for each line"
PLANNING = "planning, for each line"
MEMORY = "memory to plan, for each line"


def calculation(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the lines of the calculation; none where builds were not measured."""
    found = {row.name.partition(" lines, ")[2] or row.name: row for row in rows}
    if not {*WAYS.values(), *SIZES.values(), PACKED, RECORD, PLANNING, MEMORY} <= {*found}:
        return
    yield f"\non paper: {LINES:,} lines x {LANGUAGES} languages x {CHARACTERS} characters"
    yield f"= {TAKES:,} takes that are timed beforehand, on machines of two cores"
    yield f"{'':<14}{'one machine':>12}{f'{MACHINES} machines':>14}{'disk':>11}{'a day':>9}"
    for way, name in WAYS.items():
        rate = found[name].more["lines/s"]
        hours, daily = TAKES / rate / 3600, CHANGED * LANGUAGES * CHARACTERS / rate / 60
        kilobytes = sum(found[key].value for kind, key in SIZES.items() if kind in way)
        yield (
            f"{way:<14}{hours:>10,.0f} h{hours / MACHINES:>12,.1f} h"
            f"{TAKES * kilobytes / 1e9:>8,.2f} TB{daily:>5,.0f} min"
        )
    yield f"{'in archives':<14}{'':<26}{TAKES * found[PACKED].value / 1e9:>8,.2f} TB"
    yield f"{'one project of':<29}{'record':>10}{'planning':>12}{'memory':>11}"
    for part, takes in (
        ("everything", TAKES),
        ("one language", TAKES // LANGUAGES),
        ("one language and character", LINES),
    ):
        record, memory = takes * found[RECORD].value / 1e6, takes * found[MEMORY].value / 1e6
        minutes = takes * found[PLANNING].value / 60
        yield f"  {part:<27}{record:>7,.1f} GB{minutes:>8,.1f} min{memory:>8,.1f} GB"
