"""Timings in JSON as three lists of one length: labels, starts, and ends or durations."""

from collections.abc import Iterator

from lipsync_lang.schedules.rows import LabelRow
from lipsync_lang.schedules.timing_file import TimingFile


def listed_rows(  # noqa: PLR0913 optional parts of a format
    source: TimingFile,
    labels: object,
    starts: object,
    ends: object,
    *,
    form: str,
    line: int | None = None,
    durations: bool = False,
) -> Iterator[LabelRow]:
    """Yield rows of three lists, in the file's unit.

    Parameters
    ----------
    source : the file, for messages
    labels, starts, ends : values of the file, which may be anything
    form : an example of the format, for the error about anything else
    line : the line of the lists, if each line of the file is JSON
    durations : True if `ends` are durations
    """
    given = (labels, starts, ends)
    lists = [one for one in given if isinstance(one, list)]
    if len(lists) != len(given) or len(set(map(len, lists))) != 1:
        raise source.fault(f"needs three lists of one length; the form is {form}", line)
    for label, first, second in zip(*lists, strict=True):
        start, end = source.number(first, line), source.number(second, line)
        yield LabelRow(str(label), start, start + end if durations else end, line)
