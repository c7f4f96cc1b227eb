"""Options of `study` and its actions."""

from lipsync_lang.commands import study_reports
from lipsync_lang.commands.shared_options import Add, adder
from lipsync_lang.commands.study_making_options import add_new, add_serve
from lipsync_lang.commands.study_report_options import add_power, add_report


def add_study(add: Add) -> None:
    """Add `study`."""
    study_ = add(
        "study",
        study_reports.report,
        "ask people which of two methods they prefer, and report their choices",
        "study report study/",
    )
    actions = study_.add_subparsers(title="actions", metavar="ACTION", required=True)
    action = adder(actions)
    add_new(action)
    add_serve(action)
    add_report(action)
    add_power(action)
