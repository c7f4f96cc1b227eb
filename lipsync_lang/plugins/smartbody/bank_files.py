"""Readers of SmartBody phone-bigram banks (bigram = diphone, pose = viseme in SmartBody).

Times are relative to the bigram and weights are dimensionless, both as in the file. A bank maps a
set name to pairs of phonemes, a pair to shapes, and a shape to a list of (time, weight) keys.

The two formats, after the published SmartBody sources (`VisemeViewerWindow::OnSaveCB`, the bigram
editor; `SBDiphone::addKey`; `SBPhonemeManager::exportForService`):

- The editor saves Python scripts, and SmartBody executes them on load. Keys may be in any order,
  because `addKey` inserts by time. `createDiphone` returns an existing pair, so keys of repeated
  calls accumulate. Phoneme names are case-insensitive::

    diphoneManager = scene.getDiphoneManager()
    diphoneManager.deleteDiphoneSet("default")

    diphone = diphoneManager.createDiphone("f", "ah", "default")
    diphone.addKey("FV", 0.0105, 0)
    diphone.addKey("FV", 0.24871, 0.70313)

- `exportForService` writes text: the phoneme map, then every pair with its shapes. A shape line has
  a count of numbers, followed by alternating times and weights. Sets are concatenated without
  names. Pairs with silence are lost, because the export splits their names at `_`::

    Map ae ah
    Diphone f ah
    Shape FV 4 0.0105 0 0.24871 0.70313

For safety, scripts are never executed. The parser handles one statement at a time and accepts only
calls of these forms, with literals or names of literals as arguments; a remark reports the rest.
"""

import ast
import math
import tokenize
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import NamedTuple, TypeAlias

from lipsync_lang import PackError
from lipsync_lang.packs.yaml.faults import visible

MAX_SCRIPT_BYTES = 10_000_000
"""Maximum file size in bytes; the largest published bank has 0.24 million."""

MOST_REMARKS = 1000
"""Maximum number of stored remarks per kind; the counts are complete."""

MAX_LINE_CHARS = 10_000
"""Maximum line length of a script in characters; tokenization time is quadratic in it."""

ALONE = "-"
"""Placeholder for the second phoneme in the curve of a single phoneme."""

KEPT = 60
"""Maximum length of a quoted line in a remark, in characters."""

LAST = ""
"""Key of the last created diphone, for `addKey` without a named receiver."""

DiphonePair: TypeAlias = tuple[str, str]
LiteralValue: TypeAlias = str | float
Point: TypeAlias = tuple[float, float]


class ImportRemark(NamedTuple):
    """A deviation of the import from the file."""

    kind: str
    file: str
    line: int
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"


@dataclass
class ImportRemarks:
    """All deviations of the import from the files."""

    kept: list[ImportRemark] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    """Number of remarks by kind."""

    def add(self, kind: str, file: str, line: int, text: str) -> None:
        """Count a remark, and store it below the limit of its kind."""
        self.counts[kind] += 1
        if self.counts[kind] <= MOST_REMARKS:
            self.kept.append(ImportRemark(kind, file, line, text))


@dataclass(eq=False)
class Diphone:
    """The unmodified keys of one pair."""

    file: str
    line: int
    shapes: dict[str, list[Point]] = field(default_factory=dict)
    """Lists of (time, weight) by shape, in file order."""


Sets: TypeAlias = dict[str, dict[DiphonePair, Diphone]]
"""Diphones by pair by set name; phonemes are in lower case."""


def read_smartbody(path: Path, remarks: ImportRemarks) -> Sets:
    """Read a bank, a script or a text export; `remarks` collects unsupported content."""
    name = visible(str(path))
    try:
        if path.stat().st_size > MAX_SCRIPT_BYTES:
            raise PackError(
                f"{name}: has more than {MAX_SCRIPT_BYTES // 1_000_000} MB, which no bank needs; "
                "give the script or text that holds the bank alone"
            )
        with path.open("rb") as stream:
            # One more than the limit: a file may grow after `stat`, and a pipe has no size.
            content = stream.read(MAX_SCRIPT_BYTES + 1)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise PackError(f"{name}: cannot be read: {why}") from None
    try:
        text, why = content.decode("utf-8-sig"), "it has a zero byte"
    except UnicodeDecodeError as error:
        text, why = "\0", f"byte {error.start} is not UTF-8"
    if "\0" in text or len(content) > MAX_SCRIPT_BYTES:
        raise PackError(f"{name}: is not a script or text of SmartBody: {why}")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    # The first word tells an export: no call of a script begins so.
    words = next((line.split() for line in text.split("\n") if line.strip()), [""])
    if words[0] in {"Map", "Diphone"}:
        return _Export(name, remarks).read(text)
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        if len(line) > MAX_LINE_CHARS:
            what = f"cannot be read from this line on: it has {len(line):,} characters; the limit "
            what += f"is {MAX_LINE_CHARS:,}; write one call per line"
            remarks.add("statement", name, number, what)
            text = "\n".join(lines[: number - 1])
            break
    return _Script(name, remarks).read(text)


class _Statement(NamedTuple):
    """A top-level statement."""

    line: int
    text: str
    bound: frozenset[str] | None
    """Possible bindings of a compound statement, such as a loop; None for a simple one."""


class _Script:
    """State of the interpretation of a script: bindings and diphones."""

    def __init__(self, file: str, remarks: ImportRemarks) -> None:
        self.file, self.remarks = file, remarks
        self.sets: Sets = {}
        self.values: dict[str, LiteralValue] = {}
        """Literal values by variable name."""
        self.made: dict[str, Diphone | None] = {}
        """Diphones by variable name and under `LAST`; None for an invalid one."""
        self.line = 0

    def read(self, text: str) -> Sets:
        """Interpret the statements in order."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # invalid escapes in script strings
            try:
                for statement in _statements(text):
                    self._statement(statement)
            except tokenize.TokenError as error:
                why, (line, _) = error.args
                self._tell(f"cannot be read beyond this line: {why}", line)
            except SyntaxError as error:
                self._tell(f"cannot be read beyond this line: {error.msg}", error.lineno)
        return self.sets

    def _tell(self, text: str, line: int | None = None) -> None:
        self.remarks.add("statement", self.file, line or self.line, text)

    def _statement(self, statement: _Statement) -> None:
        self.line = statement.line
        shown = visible(statement.text.strip().split("\n")[0][:KEPT])
        if statement.bound is not None:
            self._forget(statement.bound)
            self._tell(f"block skipped: `{shown}`; write its calls one by one")
            return
        try:
            body = ast.parse(statement.text).body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            self._tell(f"not understood and skipped: `{shown}`")
            return
        for node in body:
            if not self._node(node):
                # What a skipped statement may have assigned is unknown from here on.
                inner = (n for n in ast.walk(node) if isinstance(n, ast.Name))
                self._forget({n.id for n in inner if isinstance(n.ctx, ast.Store)})
                self._tell(f"not understood and skipped: `{shown}`")

    def _forget(self, names: Iterable[str]) -> None:
        """Discard the values of names with a possible new binding."""
        for name in names:
            self.values.pop(name, None)
            if name in self.made:
                self.made[name] = None

    def _node(self, node: ast.stmt) -> bool:
        """Interpret a statement; false if it is unsupported and without a remark so far."""
        if isinstance(node, ast.Assign):
            names = [target.id for target in node.targets if isinstance(target, ast.Name)]
            return len(names) == len(node.targets) and self._assign(names, node.value)
        if not isinstance(node, ast.Expr):
            return isinstance(node, ast.Pass)
        call = node.value
        if not isinstance(call, ast.Call):
            return isinstance(call, ast.Constant) and isinstance(call.value, str)
        # By the last part alone: scripts may give the manager any name.
        match _called(call):
            case "createDiphone":
                self._create(call)
            case "addKey":
                self._add_key(call)
            case "deleteDiphoneSet":
                values = self._arguments(call, (str,))
                if values is not None:
                    self.sets.pop(str(values[0]), None)
            case _:
                return False
        return True

    def _assign(self, names: list[str], value: ast.expr) -> bool:
        self._forget(names)
        if isinstance(value, ast.Call) and _called(value) == "createDiphone":
            self.made.update(dict.fromkeys(names, self._create(value)))
            return True
        for name in names:
            self.made.pop(name, None)
        literal = self._literal(value)
        if literal is not None:
            self.values.update(dict.fromkeys(names, literal))
            return True
        return isinstance(value, ast.Call) and _called(value) == "getDiphoneManager"

    def _literal(self, node: ast.expr) -> LiteralValue | None:
        """Return the value of a string, number or bound name; None for other expressions."""
        if isinstance(node, ast.Name):
            return self.values.get(node.id)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
            inner = self._literal(node.operand) if isinstance(node.operand, ast.Constant) else None
            if inner is None or isinstance(inner, str):
                return None
            return -inner if isinstance(node.op, ast.USub) else inner
        value = node.value if isinstance(node, ast.Constant) else None
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            return None
        try:
            return value if isinstance(value, str) else float(value)
        except OverflowError:  # literals have no sign
            return math.inf

    def _arguments(self, call: ast.Call, forms: tuple[type, ...]) -> list[LiteralValue] | None:
        """Return the arguments of a call; for a type mismatch, add a remark and return None."""
        values = [self._literal(node) for node in call.args]
        fit = len(values) == len(forms) and all(map(isinstance, values, forms))
        if not fit or call.keywords:
            name = _called(call)
            needs = ", ".join("a text" if form is str else "a number" for form in forms)
            self._tell(f"{name} is skipped: its arguments must be {needs}, as literals")
            return None
        return [value for value in values if value is not None]

    def _create(self, call: ast.Call) -> Diphone | None:
        values = self._arguments(call, (str, str, str))
        made = None
        if values is not None:
            first, second, name = map(str, values)
            pair = (first.casefold(), second.casefold())
            pairs = self.sets.setdefault(name, {})
            made = pairs.setdefault(pair, Diphone(self.file, self.line))
        self.made[LAST] = made
        return made

    def _add_key(self, call: ast.Call) -> None:
        receiver = call.func.value if isinstance(call.func, ast.Attribute) else None
        if isinstance(receiver, ast.Call) and _called(receiver) == "createDiphone":
            diphone = self._create(receiver)
            if diphone is None:
                return
        else:
            name = receiver.id if isinstance(receiver, ast.Name) else LAST
            known = (receiver is None or name) and name in self.made
            diphone = self.made[name] if known else None
            if diphone is None:
                why = "because the createDiphone before it was skipped"
                self._tell(
                    f"addKey is skipped, {why}"
                    if known
                    else "addKey is skipped: no createDiphone made its diphone"
                )
                return
        values = self._arguments(call, (str, float, float))
        if values is not None:
            time, weight = float(values[1]), float(values[2])
            _key(diphone, str(values[0]), time, weight, self.remarks, self.line)


def _called(call: ast.Call) -> str:
    """Return the last component of a called name: `addKey` of `diphone.addKey`."""
    if isinstance(call.func, ast.Attribute):
        return call.func.attr
    return call.func.id if isinstance(call.func, ast.Name) else ""


def _key(  # noqa: PLR0913, PLR0917 a key, and its place in the file
    diphone: Diphone, shape: str, time: float, weight: float, remarks: ImportRemarks, line: int
) -> None:
    if math.isfinite(time) and math.isfinite(weight):
        diphone.shapes.setdefault(shape, []).append((time, weight))
    else:
        remarks.add("number", diphone.file, line, "a key that is not finite is skipped")


SPACE = {tokenize.NL, tokenize.COMMENT}
ENDS = {tokenize.NEWLINE, tokenize.ENDMARKER}
BINDERS = {"for", "as", "def", "class", "import", "del", "global"}


class _LogicalLine(NamedTuple):
    """A logical line of a script, possibly of several physical lines."""

    depth: int
    first: int
    last: int
    names: set[str]
    """Possible bindings in the line."""


def _statements(text: str) -> Iterator[_Statement]:
    """Split a script into top-level statements, without a syntax check."""
    lines = text.split("\n")
    head: _LogicalLine | None = None
    names: set[str] = set()
    body = False

    def statement(head: _LogicalLine) -> _Statement:
        source = "\n".join(lines[head.first - 1 : head.last])
        return _Statement(head.first, source, frozenset(names) if body else None)

    fault: Exception | None = None
    try:
        for line in _lines(text):
            if line.depth:
                names |= line.names
                body = True
            else:
                if head:
                    yield statement(head)
                head, names, body = line, line.names, False
    except (tokenize.TokenError, SyntaxError) as error:  # earlier statements remain valid
        fault = error
    if head:
        yield statement(head)
    if fault is not None:
        raise fault


def _lines(text: str) -> Iterator[_LogicalLine]:
    depth, start, before = 0, 0, ""
    names: set[str] = set()
    for token in tokenize.generate_tokens(StringIO(text).readline):
        if token.type == tokenize.INDENT:
            depth += 1
        elif token.type == tokenize.DEDENT:
            depth -= 1
        elif token.type in ENDS:
            if start:
                yield _LogicalLine(depth, start, token.start[0], names)
            start = 0
        elif token.type not in SPACE:
            if not start:
                start, names = token.start[0], set()
            if token.string == "=" or before in BINDERS:
                names.add(token.string if before in BINDERS else before)
        before = token.string


class _Export:
    """State of the interpretation of a text export."""

    def __init__(self, file: str, remarks: ImportRemarks) -> None:
        self.file, self.remarks = file, remarks
        self.pairs: dict[DiphonePair, Diphone] = {}
        self.now: Diphone | None = None
        self.mapped = 0

    def read(self, text: str) -> Sets:
        """Interpret the lines in order."""
        for number, line in enumerate(text.split("\n"), start=1):
            match line.split():
                case []:
                    pass
                case ["Map", _, _]:
                    self.mapped += 1
                case ["Diphone", first, second]:
                    pair = (first.casefold(), second.casefold())
                    self.now = Diphone(self.file, number)
                    if pair in self.pairs:
                        shown = visible("-".join(pair))
                        what = f"{shown} is repeated, from another set; the first is kept"
                        self.remarks.add("twice", self.file, number, what)
                    # The shapes of a repeated pair are read into `now`, and go with it.
                    self.pairs.setdefault(pair, self.now)
                case ["Shape", *words] if self.now is not None:
                    self._shape(number, self.now, words)
                case _:
                    self._tell(number, f"not understood: `{visible(line.strip()[:KEPT])}`")
        if self.mapped:
            what = f"{self.mapped} Map lines are skipped: languages map their own sounds"
            self.remarks.add("map", self.file, 1, what)
        return {"": self.pairs} if self.pairs else {}

    def _tell(self, line: int, text: str) -> None:
        self.remarks.add("statement", self.file, line, text)

    def _shape(self, line: int, diphone: Diphone, words: list[str]) -> None:
        """Read a shape line: a name with possible spaces, a count, and that many numbers."""
        # The first count that fits the rest of the line ends the name, which may hold numbers.
        at = next((n for n in range(1, len(words)) if words[n] == str(len(words) - n - 1)), None)
        try:
            numbers = [float(word) for word in words[at + 1 :]] if at else None
        except ValueError:
            numbers = None
        if not at or numbers is None or len(numbers) % 2:
            what = "this Shape is skipped: it needs a name, a count, and as many numbers, in pairs"
            self._tell(line, what)
            return
        name = " ".join(words[:at])
        for time, weight in zip(numbers[::2], numbers[1::2], strict=True):
            _key(diphone, name, time, weight, self.remarks, line)
