"""Options of the commands for first runs: new and doctor."""

from lipsync_lang.commands.doctor import doctor
from lipsync_lang.commands.shared_options import Add, add_json
from lipsync_lang.commands.starting import new


def add_new(add: Add) -> None:
    """Add `new`."""
    made = add(
        "new",
        new,
        "make a project folder with a script, a character and a README",
        "new my-game -l finnish",
    )
    made.add_argument("name", metavar="NAME", help="the name of the new folder")
    made.add_argument(
        "-l", "--language", metavar="LANGUAGE", dest="new_language",
        help="the language of the lines, by name or tag [english]",
    )  # fmt: skip
    made.add_argument(
        "-c", "--character", metavar="CHARACTER", dest="new_character",
        help="the pose set of the new character, or an installed character [facefx]",
    )  # fmt: skip


def add_doctor(add: Add) -> None:
    """Add `doctor`."""
    made = add("doctor", doctor, "check the installation, and say how to mend it", "doctor")
    add_json(made)
