"""Options of `study` and its actions."""

import argparse

from lipsync_lang.commands import study_reports
from lipsync_lang.commands.shared_options import Add, Command
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

    def action(name: str, command: Command, title: str, example: str) -> argparse.ArgumentParser:
        made = actions.add_parser(
            name,
            help=title,
            description=f"{title[0].upper()}{title[1:]}.",
            epilog=f"example:\n  lipsync-lang {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        made.set_defaults(command=command)
        return made

    add_new(action)
    add_serve(action)
    add_report(action)
    add_power(action)
