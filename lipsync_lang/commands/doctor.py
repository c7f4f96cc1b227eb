"""The command that checks an installation, and says how to mend each part."""

import sys
from argparse import Namespace
from time import perf_counter

from lipsync_lang.commands.output import FAULTS, SOUND, as_json, working
from lipsync_lang.commands.registry import handler


@handler("doctor", "check the installation, and say how to mend it", "doctor")
def doctor(options: Namespace) -> int:
    """Print the state of every part; parts that are broken or that the project lacks are faults."""
    from lipsync_lang.commands import doctor_checks
    from lipsync_lang.commands.doctor_checks import BROKEN, MISSING, PROJECT, CheckedPart

    start = perf_counter()
    with working("checking"):
        found: list[CheckedPart] = []
        for check in (*doctor_checks.CHECKS, *doctor_checks.MORE_CHECKS.values()):
            try:
                found += list(check())
            except Exception as error:  # noqa: BLE001 any error in a check is its finding
                part = check.__name__.strip("_").replace("_", " ")
                found.append(CheckedPart(part, BROKEN, f"{type(error).__name__}: {error}"))
    if options.json:
        print(as_json([one._asdict() for one in found]))
    else:
        from lipsync_lang.base.presentation.text_table import columns

        rows = list(columns([(one.state, one.part, one.told) for one in found]))
        for section in (doctor_checks.ALWAYS, PROJECT, doctor_checks.OPTIONAL):
            own = [row for row, one in zip(rows, found, strict=True) if one.section == section]
            if own:
                print("\n".join([f"{section}:", *own]))
    print(f"checked in {perf_counter() - start:.1f} s", file=sys.stderr)
    lacking = any(one.state == MISSING and one.section == PROJECT for one in found)
    return FAULTS if lacking or any(one.state == BROKEN for one in found) else SOUND
