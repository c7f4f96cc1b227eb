"""Options of the commands for first runs: new and doctor."""

from pathlib import Path

from lipsync_lang.commands.doctor import doctor
from lipsync_lang.commands.new_project_command import new
from lipsync_lang.commands.shared_options import Add, add_json, add_path


def add_new(add: Add) -> None:
    """Add `new`."""
    made = add(
        "new",
        new,
        "make a project: a new folder, or the project file of your recordings and table",
        "new my-game -l finnish",
    )
    made.add_argument("name", metavar="NAME", nargs="?", help="the name of the new folder")
    made.add_argument(
        "--recordings", metavar="FOLDER", type=Path,
        help="make a project of this folder of recordings in the current folder, with --from",
    )  # fmt: skip
    made.add_argument(
        "--from", metavar="TABLE", type=Path, dest="table",
        help="the script of the recordings, one row for each line",
    )  # fmt: skip
    made.add_argument(
        "-l", "--language", metavar="LANGUAGE", dest="new_language",
        help="the language of the lines, by name or tag [english; of recordings, from their "
        "folders or a column]",
    )  # fmt: skip
    made.add_argument(
        "-c", "--character", metavar="CHARACTER", action="append", default=[], dest="characters",
        help="the pose set of the new character, or an installed character; for recordings, may "
        "be repeated [facefx]",
    )  # fmt: skip
    add_path(made)
    made.set_defaults(in_project=False)


def add_doctor(add: Add) -> None:
    """Add `doctor`."""
    made = add("doctor", doctor, "check the installation, and say how to mend it", "doctor")
    add_json(made)
