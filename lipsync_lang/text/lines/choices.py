r"""Choices in braces: alternative texts, of which a game reads one.

- ICU messages: ``{n, plural, one {# coin} other {# coins}}``, and ``select`` alike,
- Fluent: ``{ $n -> [one] a coin *[other] coins }``,
- Ink: ``{first time|second time}``, ``{met: Hello again|Hello}``,
- Unity: ``{n:plural:coin|coins}``, ``{her:choose(f|m):she|he}``,
- Unreal: ``{n}|plural(one=coin,other=coins)``, ``{who}|gender(le,la)``,
- OpenTTD: ``coin{P "" s}``, ``{G le la}``.

The branch of a known value is taken; else the general one (``other``, the starred one, the last
plural), or in other choices the first that has words.
"""

import re
from collections.abc import Mapping

MAX_DEPTH = 8
"""Maximum depth of choices within choices."""

MAX_FORMS = 32
"""Maximum number of forms of one text; more are combinations that nobody records."""

ICU = re.compile(r"\s*\$?([\w.-]+)\s*,\s*(?:plural|select|selectordinal)\s*,")
FLUENT = re.compile(r"\s*\$?-?([\w.-]+)(?:\([^()]*\))?\s*->")
INK_CHOICE = re.compile(r"\s*[&!~]?\s*(?:\w[\w .()!=<>&]{0,80}:(?=\s))?")
SMART_CHOICE = re.compile(r"\s*[\w.]*:(\w+)(?:\([^()]*\))?:")
UNREAL_CHOICE = re.compile(r"\|(plural|ordinal|gender|hpp)\(([^()]*)\)")
STRING_CHOICE = re.compile(r"([PG])(?:\s+\d+(?::\d+)?)?((?:\s+(?:\"[^\"]*\"|[^\s\"]+)){2,})\s*")
BRANCH = re.compile(r"(?:^|(?<=[\s}]))(=\d+|\w+)\s*\{")
FLUENT_VARIANT = re.compile(r"(\*?)\[\s*([\w.-]+)\s*\]")
LITERAL = re.compile(r"\s*\"([^\"{}]*)\"\s*")


def chosen(text: str, values: Mapping[str, str], depth: int = 0) -> str:
    """Return a text with one branch in place of each choice; other braces are kept.

    >>> chosen("I have {n, plural, one {a coin} other {# coins}}.", {"n": "3"})
    'I have 3 coins.'
    """
    if "{" not in text or depth > MAX_DEPTH:
        return text
    ends = _ends(text)
    out: list[str] = []
    at = 0
    while (start := text.find("{", at)) >= 0:
        end = ends.get(start)
        inner = text[start + 1 : end]
        branch = None if end is None else _branch(inner, values)
        if end is not None and (given := UNREAL_CHOICE.match(text, end + 1)):
            branch, end = _of_unreal(given[1], given[2], values.get(inner)), given.end() - 1
        filtered = inner[:1] == "{" and inner[-1:] == "}" and "," not in inner
        if end is not None and filtered:  # {{name|upper}}
            out.append(text[at : end + 1])
            at = end + 1
        elif end is None or branch is None:
            out.append(text[at : start + 1])
            at = start + 1
        else:
            out += text[at:start], chosen(branch, values, depth + 1)
            at = end + 1
    return "".join([*out, text[at:]])


def _ends(text: str) -> dict[int, int]:
    """Map each opening brace to its closing one; those of inner choices only to `MAX_DEPTH`."""
    opened: list[int] = []
    ends: dict[int, int] = {}
    for found in re.finditer(r"[{}]", text):
        if found[0] == "{":
            opened.append(found.start())
        elif opened:
            start = opened.pop()
            if len(opened) < MAX_DEPTH:
                ends[start] = found.start()
    return ends


def _branch(inner: str, values: Mapping[str, str]) -> str | None:
    """Return the branch of a choice; None for braces of another kind."""
    if message := _message(inner):
        name, forms, general = message
        value = values.get(name)
        usual = forms.get("one" if value == "1" else general, forms[general])
        said = forms.get(f"={value}", forms.get(value or "", usual))
        return said if value is None else said.replace(f"{{{name}}}", value)
    if ICU.match(inner) or FLUENT.match(inner):
        return None
    if found := LITERAL.fullmatch(inner):
        return found[1]
    if found := STRING_CHOICE.fullmatch(inner):
        words = [one[1] or one[2] or "" for one in re.finditer(r"\"([^\"]*)\"|(\S+)", found[2])]
        return words[-1 if found[1] == "P" else 0]
    smart = SMART_CHOICE.match(inner) if "|" in inner else None
    found = smart or INK_CHOICE.match(inner)
    head = found.end() if found else 0
    # `{met: Hello}` is a choice without a bar; `{met}` and `{a:b}` are placeholders.
    if "|" not in inner and not (head and inner[:head].rstrip().endswith(":")):
        return None
    ways = _ways(inner[head:]) or [""]
    return ways[-1 if smart and smart[1].startswith("p") else 0]


def _ways(ways: str) -> list[str]:
    """Return the branches between bars that have words."""
    found: list[str] = []
    depth, start = 0, 0
    for mark in re.finditer(r"[{}|]|\Z", ways):
        depth += {"{": 1, "}": -1}.get(mark[0], 0)
        # A bar outside inner braces ends a branch, and so does the end, whatever is open.
        if not mark[0] or (mark[0] == "|" and depth == 0):
            if way := ways[start : mark.start()].strip():
                found.append(way)
            start = mark.end()
    return found


def _of_unreal(kind: str, listed: str, value: str | None) -> str:
    ways = [way.strip() for way in listed.split(",")]
    named = dict(way.split("=", 1) for way in ways if "=" in way)
    if kind in {"plural", "ordinal"} and named:
        return named.get("one" if value == "1" else "other", next(reversed(named.values())))
    return ways[0]


def every_form(text: str, values: Mapping[str, str]) -> list[tuple[str, str]]:
    """Return (name, text) of each form of an ICU or Fluent message whose values are unknown.

    A text without choices is one form without a name, and so is one of more than `MAX_FORMS`.

    >>> every_form("I have {n, plural, one {# coin} other {# coins}}.", {})
    [('one', 'I have {n} coin.'), ('other', 'I have {n} coins.')]
    """
    if "plural" not in text and "select" not in text and "->" not in text:
        return [("", text)]
    done: list[tuple[str, str]] = []
    ahead = [("", text, 0)]
    while ahead:
        name, said, at = ahead.pop()
        choice = _first_choice(said, at, values)
        if choice is None:
            done.append((name, said))
        else:
            start, end, branches = choice
            # The last one is taken first, so forms come in the order of the file.
            for form, branch in reversed(branches.items()):
                named = f"{name}-{form.lstrip('=')}" if name else form.lstrip("=")
                ahead.append((named, said[:start] + branch + said[end:], start))
        if len(done) + len(ahead) > MAX_FORMS:
            return [("", text)]
    return done


def _first_choice(
    text: str, at: int, values: Mapping[str, str]
) -> tuple[int, int, dict[str, str]] | None:
    """Return the start, end and branches of the first choice whose value is unknown."""
    ends = _ends(text)
    while (start := text.find("{", at)) >= 0:
        message = _message(text[start + 1 : ends.get(start, start)])
        if message and message[0] not in values:
            return start, ends[start] + 1, message[1]
        at = start + 1
    return None


def _message(inner: str) -> tuple[str, dict[str, str], str] | None:
    """Return the variable, the branches by name, and the general one of an ICU or Fluent choice."""
    if found := ICU.match(inner):
        forms = _icu_branches(inner[found.end() :])
        forms = {form: one.replace("#", f"{{{found[1]}}}") for form, one in forms.items()}
        general = "other" if "other" in forms else next(reversed(forms), "")
    elif found := FLUENT.match(inner):
        forms, general = _fluent_variants(inner[found.end() :])
    return (found[1], forms, general) if found and forms else None


def _icu_branches(branches: str) -> dict[str, str]:
    """Return the branches of an ICU choice by their names; none for an open brace."""
    ends = _ends(branches)
    found: dict[str, str] = {}
    at = 0
    while match := BRANCH.search(branches, at):
        end = ends.get(match.end() - 1)
        if end is None:
            return {}
        found[match[1]] = branches[match.end() : end]
        at = end + 1
    return found


def _fluent_variants(variants: str) -> tuple[dict[str, str], str]:
    """Return the variants of a Fluent selector by their names, and the name of the general one."""
    ends = _ends(variants)
    # Names within inner braces are variants of inner selectors.
    inner = [range(start, end) for start, end in ends.items()]
    found = [
        one for one in FLUENT_VARIANT.finditer(variants)
        if not any(one.start() in span for span in inner)
    ]  # fmt: skip
    stops = [one.start() for one in found[1:]] + [len(variants)]
    texts = {
        one[2]: variants[one.end() : stop].strip() for one, stop in zip(found, stops, strict=False)
    }
    return texts, next((one[2] for one in found if one[1]), found[-1][2] if found else "")
