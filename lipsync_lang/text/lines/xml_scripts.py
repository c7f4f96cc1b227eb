"""Scripts in XML: files for translation that differ in names of elements and attributes alone.

An `XmlScript` states as data which elements are entries, and where their fields are, in
`script_formats.json` or in a project. A path such as ``notes/note`` leads from an entry to
elements, and ``@id`` to an attribute at its end. Elements within a text are markup, and each part
of an entry is a line.

The parser is the standard one: it gives the line of each element, and its handlers refuse
definitions of entities before any is expanded. Files of others are never opened.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any
from xml.parsers import expat

from lipsync_lang.base.errors import LipsyncError, ScheduleError
from lipsync_lang.text.lines.columns import language_column
from lipsync_lang.text.lines.entries import MAX_ENTRY_DEPTH, ScriptEntry, entry_lines, whole_file
from lipsync_lang.text.lines.line_readers import Line, LineFile, StatedScript
from lipsync_lang.text.lines.plain import PROPERTY_ESCAPE, unescaped

MAX_XML_DEPTH = 2 * MAX_ENTRY_DEPTH
"""Maximum depth of elements; those within a text count, too."""

INLINE_CODES = ("x", "ph")
"""Elements of XLIFF that stand for a value; all others without a text are tags."""

PLACEHOLDER_NAMES = ("equiv-text", "disp", "equiv", "id")
"""Attributes that name the content of an element without a text, the clearest first."""


@dataclass(frozen=True)
class XmlScript(StatedScript):
    """A format of scripts in XML."""

    entries: str = ""
    """Names of the elements that are entries."""
    root: str = ""
    """Name of the outermost element, if the suffix does not tell."""
    each: str = "."
    """Path from an entry to its parts, such as segments; each has a text."""
    form: str = ""
    """Attribute of a part with the name of its form, such as a plural; numbers by default."""
    without: Sequence[str] = ()
    """Attributes of an element that is no entry."""
    source_language: str = ""
    target_language: str = ""
    """Attributes of elements around entries: the languages of their original and their text."""
    escapes: bool = False
    """True if a backslash begins an escape."""

    def read(self, source: LineFile) -> Iterator[Line]:
        """Yield the lines of a file, in the format that its outermost element tells."""
        file = whole_file(source)
        suffix = source.path.suffix.lower()
        alike = [one for one in XML_SCRIPTS.values() if suffix in one.suffixes]
        fitting = [one for one in alike if one.root and file.has_root(one.root)]
        chosen = next(iter(fitting), self)
        if chosen.root and not fitting:
            known = " or ".join(f"<{one.root}>" for one in alike if one.root)
            raise source.fault(1, f"begins with no {known}; check that it is a script")
        return entry_lines(source, _Parsing(chosen, source).entries(file.text))


XML_SCRIPTS: dict[str, XmlScript] = {}
"""Formats by name, those of a project included."""


@dataclass(slots=True)
class _Element:
    """An element within an entry, with its texts and elements in order."""

    tag: str
    attributes: dict[str, str]
    parts: list["str | _Element"] = field(default_factory=list)
    inner: dict[str, list["_Element"]] = field(default_factory=dict)
    """The elements among the parts, by their names."""

    def at(self, names: Sequence[str]) -> list["_Element"]:
        """Return the elements at a path."""
        if not names:
            return [self]
        return [one for node in self.inner.get(names[0], ()) for one in node.at(names[1:])]

    def first(self, paths: str) -> list["_Element"]:
        """Return the elements at the first path that leads to some."""
        for names, _ in _ways(paths):
            if found := self.at(names):
                return found
        return []

    def value(self, paths: str) -> str:
        """Return the first text or attribute at one of the paths that is not empty."""
        for names, attribute in _ways(paths):
            for node in self.at(names):
                found = node.attributes.get(attribute, "") if attribute else node.text()
                if found and not found.isspace():
                    return found
        return ""

    def text(self) -> str:
        """Return the text, with placeholders for the elements that have none."""
        return "".join(
            one if isinstance(one, str) else one.text() or one.sign() for one in self.parts
        )

    def sign(self) -> str:
        """Return the placeholder or the tag that an element without a text is."""
        if self.tag not in INLINE_CODES:
            return f"<{self.tag}/>"
        named = (self.attributes.get(name) for name in PLACEHOLDER_NAMES)
        name = next(filter(None, named), self.tag)
        # `equiv-text` may have the placeholder itself, such as `%s`.
        return name if set("{}<>%[]$") & set(name) else f"{{{name}}}"


@cache
def _ways(paths: str) -> tuple[tuple[tuple[str, ...], str], ...]:
    """Return (names of elements, attribute at the end) of paths with bars between them."""
    parts = (path.partition("@") for path in paths.split("|") if path)
    return tuple(
        (tuple(name for name in way.split("/") if name not in ("", ".")), attribute)
        for way, _, attribute in parts
    )


@dataclass
class _Parsing:
    """The parser of one file: entries are kept, and all other elements are forgotten."""

    script: XmlScript
    source: LineFile
    found: list[tuple[str, ScriptEntry]] = field(default_factory=list)
    """Entries, each with the language of its text; empty if the file does not state it."""
    depth: int = 0
    open: list[_Element] = field(default_factory=list)
    languages: list[tuple[int, str, str]] = field(default_factory=lambda: [(0, "", "")])
    """Depth and languages of the elements around an entry."""
    line: int = 1
    asked: dict[str, bool] = field(default_factory=dict)
    """The languages of the file, with True for the one that is read."""
    parser: expat.XMLParserType = field(init=False)

    def entries(self, text: str) -> Iterator[ScriptEntry]:
        """Yield the entries of a file in the language that is read, or in all if it has none."""
        parser = self.parser = expat.ParserCreate("utf-8")
        # Without this, each row of a text comes alone.
        parser.buffer_text = True
        parser.StartElementHandler = self.start
        parser.EndElementHandler = self.end
        parser.CharacterDataHandler = self.characters
        parser.StartDoctypeDeclHandler = self.doctype
        parser.SkippedEntityHandler = self.entity
        try:
            # The text is decoded already; the encoding that it states no longer counts.
            parser.Parse(text.encode("utf-8", "replace"), True)  # noqa: FBT003
        except expat.ExpatError as error:
            what = f"not XML: {expat.ErrorString(error.code)}; correct the file, or export it again"
            raise self.source.fault(error.lineno, what) from None
        if not self.found:
            names = " or ".join(f"<{name}>" for name in self.script.entries.split("|"))
            raise ScheduleError(
                f"{self.source.path}: has no {names}, so it is not {self.script.name}; check the "
                "file, or the names of its format"
            )
        own = [one for language, one in self.found if self.is_asked(language)]
        others = dict.fromkeys(language for language, _ in self.found if language)
        if self.source.names and others and not own:
            what = f"no text is in {self.source.names[0]}; the text in {', '.join(others)} is read"
            self.source.remark(f"{self.source.path}: {what}")
        yield from own or (one for _, one in self.found)

    def is_asked(self, language: str) -> bool:
        """Return True for the language that is read."""
        if language not in self.asked:
            # As in the head of a table: regions and aliases count.
            self.asked[language] = language_column(["", language], self.source.names) > 0
        return self.asked[language]

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """Enter an element."""
        self.depth += 1
        if self.depth > MAX_XML_DEPTH:
            what = f"is nested deeper than {MAX_XML_DEPTH} elements; check what wrote it"
            raise self.source.fault(self.parser.CurrentLineNumber, what)
        # The prefix of a namespace is the choice of the program that wrote it.
        tag = tag[tag.find(":") + 1 :]
        if self.open:
            node, around = _Element(tag, attributes), self.open[-1]
            around.parts.append(node)
            around.inner.setdefault(tag, []).append(node)
            self.open.append(node)
        elif tag in self.script.entries.split("|"):
            self.line = self.parser.CurrentLineNumber
            self.open.append(_Element(tag, attributes))
        elif attributes:
            _, *before = self.languages[-1]
            names = self.script.source_language, self.script.target_language
            source, target = (
                next(filter(None, map(attributes.get, name.split("|"))), old)
                for name, old in zip(names, before, strict=True)
            )
            if [source, target] != before:
                self.languages.append((self.depth, source, target))

    def end(self, _: str) -> None:
        """Leave an element."""
        if self.open:
            node = self.open.pop()
            if not self.open:
                self.keep(node)
        elif self.languages[-1][0] == self.depth > 0:
            self.languages.pop()
        self.depth -= 1

    def characters(self, text: str) -> None:
        """Take a text."""
        if self.open:
            self.open[-1].parts.append(text)

    def doctype(self, *stated: Any) -> None:
        """Refuse a document type that defines something; a mere name of one is read."""
        if stated[-1]:
            raise self.refusal("has a DOCTYPE with definitions, which are never read")

    def entity(self, name: str, _: bool) -> None:  # noqa: FBT001
        """Refuse an entity that another file would define."""
        raise self.refusal(f"has the entity '&{name};', whose definition is never read")

    def refusal(self, what: str) -> LipsyncError:
        """Return an error at the place of the parser."""
        return self.source.fault(self.parser.CurrentLineNumber, f"{what}; write its text instead")

    def keep(self, node: _Element) -> None:
        """Keep the texts of an entry."""
        script, (_, source, target) = self.script, self.languages[-1]
        if not node.attributes.keys().isdisjoint(script.without):
            return
        is_original = self.is_asked(source) and not self.is_asked(target)
        name = node.value(script.id)
        notes = tuple(one.text() for names, _ in _ways(script.note) for one in node.at(names))
        for at, part in enumerate(node.first(script.each)):
            text, original = part.value(script.text), part.value(script.original)
            form = part.value(script.form) or (str(at) if at else "")
            said = original if is_original else text
            entry = ScriptEntry(
                self.line,
                f"{name}-{form}" if form else name,
                PROPERTY_ESCAPE.sub(unescaped, said) if script.escapes else said,
                "" if is_original else original,
                node.value(script.speaker),
                notes,
                ready=is_original or part.value(script.state) not in script.unready,
            )
            self.found.append((source if is_original else target, entry))
