"""JUnit XML of a build, for build servers: a suite per language and character, a case per line."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TextIO
from xml.sax.saxutils import escape, quoteattr

from lipsync_lang.build.build_tally import BuildHeading, BuildTally
from lipsync_lang.build.planned_line import BuiltLine, JudgedFigure
from lipsync_lang.files.xml_text import xml_text

COUNTS = ("tests", "errors", "failures", "skipped")


@dataclass(frozen=True)
class _Case:
    name: str
    place: str
    kind: str = ""
    message: str = ""
    detail: str = ""

    def xml(self, suite: str) -> str:
        """Return the case as XML."""
        known = {"classname": suite, "name": self.name, "file": self.place.rpartition(":")[0]}
        start = f"<testcase{_attributes({name: text for name, text in known.items() if text})}"
        if not self.kind:
            return f"{start}/>"
        told = f"<{self.kind}{_attributes({'message': self.message})}"
        told += f">{escape(xml_text(self.detail))}</{self.kind}>" if self.detail else "/>"
        return f"{start}>{told}</testcase>"


class JunitReport:
    """Cases of a build; a line that failed is an error, one over a limit a failure.

    A line is skipped if one of its outputs was left alone, because somebody changed it.
    """

    def __init__(self, heading: BuildHeading) -> None:
        self._heading = heading
        self._kept = frozenset(heading.kept)
        self._suites: dict[str, list[_Case]] = {}

    def add(self, line: BuiltLine) -> None:
        """Add the case of a line."""
        suite = f"{line.line.language} on {line.line.character}"
        self._suites.setdefault(suite, []).append(self._case(line))

    def _case(self, line: BuiltLine) -> _Case:
        name, place = line.line.name, line.line.place
        if line.outcome == "failed":
            return _Case(name, place, "error", line.message)
        if line.failed:
            words = [limited(figure) for figure in line.failed]
            found = "\n".join(f"{figure.name}: {_found(figure)}" for figure in line.failed)
            return _Case(name, place, "failure", "; ".join(words), f"{place}\n{found}")
        kept = [path for _, path in line.line.outputs if path in self._kept]
        if kept:
            return _Case(name, place, "skipped", f"kept, because it was changed: {', '.join(kept)}")
        return _Case(name, place)

    def write(self, out: TextIO, tally: BuildTally) -> None:
        """Write the suites."""
        del tally  # cases are counted as they are written
        head = {"name": self._heading.project, **_counts(self._cases())}
        head["time"] = f"{self._heading.seconds:.3f}"
        out.write('<?xml version="1.0" encoding="UTF-8"?>\n')
        out.write(f"<testsuites{_attributes(head)}>\n")
        for name, cases in self._suites.items():
            out.write(f"  <testsuite{_attributes({'name': name, **_counts(iter(cases))})}>\n")
            out.writelines(f"    {case.xml(name)}\n" for case in cases)
            out.write("  </testsuite>\n")
        out.write("</testsuites>\n")

    def _cases(self) -> Iterator[_Case]:
        return (case for cases in self._suites.values() for case in cases)


def _counts(cases: Iterator[_Case]) -> dict[str, str]:
    found = dict.fromkeys(COUNTS, 0)
    kinds = {"error": "errors", "failure": "failures", "skipped": "skipped"}
    for case in cases:
        found["tests"] += 1
        if case.kind:
            found[kinds[case.kind]] += 1
    return {name: str(number) for name, number in found.items()}


def _attributes(values: dict[str, str]) -> str:
    return "".join(f" {name}={quoteattr(xml_text(value))}" for name, value in values.items())


def limited(figure: JudgedFigure) -> str:
    """Return a figure with its limit in words: `speed 14.2 per second, at most 12`."""
    words = f"{figure.name} {figure.value:.4g} {figure.unit}".rstrip()
    return words if figure.limit is None else f"{words}, at most {figure.limit:g}"


def _found(figure: JudgedFigure) -> str:
    times = ", ".join(f"{at:.3f} s" for at in figure.at)
    return ": ".join(part for part in (times, figure.words) if part)
