"""Fuzz targets of the plug-ins: captures, banks of SmartBody, proposals of fits, and studies."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from fuzz.targets import Target

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.models import ReadOut
from lipsync_lang.plugins.capture.capture_files import find_captures
from lipsync_lang.plugins.capture.capture_reading import read_sensors
from lipsync_lang.plugins.capture.fit_file import read_fit
from lipsync_lang.plugins.smartbody.bank_files import ImportRemarks, read_smartbody
from lipsync_lang.plugins.study.preference_page import report_page
from lipsync_lang.plugins.study.study_file import Submission, parsed, read_study, texts_of
from lipsync_lang.plugins.study.study_report import report_study
from lipsync_lang.plugins.study.study_text import report_text

HERE = Path(__file__).parent

READ_OUT = ReadOut(
    kind="readout", format=1, measures={"aperture": {"up": 1, "low": -1}, "other": {"low": 2}}
)


def plug_in_targets() -> Iterator[Target]:
    """Yield the targets of the plug-ins."""
    target = partial(Target, home=HERE)
    yield target("captures/list", _listed)
    yield target("captures/sensors", lambda path: read_sensors(path, READ_OUT))
    yield target("banks/smartbody", lambda path: read_smartbody(path, ImportRemarks()))
    yield target("banks/fit", read_fit, share=0.2)
    yield target("study/key", read_study)
    yield target("study/answers", _answers)
    yield target("study/report", _report)


def _listed(path: Path) -> None:
    for one in find_captures(path)[0]:
        assert one.capture.resolve().is_relative_to(path.parent.resolve())


def _answers(path: Path) -> None:
    for place, text in texts_of([path]):
        if isinstance(text, LipsyncError):
            raise text
        parsed(Submission, text, place)


def _report(path: Path) -> None:
    report = report_study(HERE / "seeds/study/key/study.json", [path])
    whole = sum(one.submissions for one in report.answers.set_aside)
    assert report.answers.submissions == report.answers.raters + whole
    assert isinstance(report_text(report) + report_page(report), str)
