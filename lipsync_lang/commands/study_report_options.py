"""Options of `study report` and `study power`."""

from pathlib import Path

from lipsync_lang.commands import study_reports
from lipsync_lang.commands.shared_options import Add, add_json, add_json_form
from lipsync_lang.files import argument_path


def add_report(action: Add) -> None:
    """Add `study report`."""
    made = action(
        "report",
        study_reports.report,
        "report which method people prefer, how strongly, and how certain the result is",
        "study report study/ -o report.html",
    )
    made.add_argument("study", metavar="STUDY", type=Path, help="the study's folder")
    made.add_argument(
        "answers", metavar="ANSWERS", type=argument_path, nargs="*",
        help="files of answers, or folders of them; - is standard input [those in the study's "
        "folder]",
    )  # fmt: skip
    made.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=argument_path,
        help="write to a file, as HTML, JSON or text by its suffix; - is standard output [print "
        "it]",
    )
    made.add_argument(
        "--format",
        metavar="NAME",
        help="output format: text, json, html [by the suffix of -o, else text]",
    )
    add_json_form(made)
    made.add_argument(
        "--failed-checks", metavar="N", type=int, default=0,
        help="number of attention checks that a rater may fail [0]",
    )  # fmt: skip
    made.add_argument(
        "--least-seconds", metavar="N", type=float,
        help="shortest time for a pair [the length of the clip]",
    )  # fmt: skip
    made.add_argument(
        "--one-side", metavar="N", type=int, default=10,
        help="exclude a rater who chooses one side in all of N or more pairs; 0 for never [10]",
    )  # fmt: skip
    made.add_argument(
        "--keep-unfinished", action="store_true", help="count raters who stopped early, too"
    )


def add_power(action: Add) -> None:
    """Add `study power`."""
    made = action(
        "power",
        study_reports.power,
        "compute the raters and pairs that a study needs, or the power of a design",
        "study power --share 0.6 --pairs 20",
    )
    made.add_argument(
        "--share", metavar="X", type=float, required=True,
        help="expected share of choices for the better method, such as 0.6",
    )  # fmt: skip
    made.add_argument(
        "--raters", metavar="N", type=int, help="number of raters [as many as needed]"
    )
    made.add_argument(
        "--pairs", metavar="N", type=int, help="number of pairs per rater [10, 20 and 40]"
    )
    made.add_argument(
        "--power", metavar="X", type=float, default=0.8,
        help="wanted probability of a significant result [0.8]",
    )  # fmt: skip
    made.add_argument(
        "--alpha", metavar="X", type=float, default=0.05,
        help="level of the two-sided test [0.05]",
    )  # fmt: skip
    made.add_argument(
        "--correlation", metavar="X", type=float, default=0.1,
        help="correlation of the choices of one rater, 0 to 1; the report of a study measures it "
        "[0.1]",
    )  # fmt: skip
    add_json(made)
