r"""What of a written line is spoken.

Left out, and returned so that it can be named:

- tags: ``<i>``, ``{i}``, ``{/color}``, ``{\an8}``; the words between two tags stay,
- ruby, the small reading above a word: ``<rt>..</rt>``, ``{rt}..{/rt}``,
- placeholders whose value only the game knows: ``{name}``, ``[name]``, ``%s``, ``%(name)s``,
  ``$name``; what stands in square brackets for people, ``[sighs]``, is not spoken either,
- notes of music.

Doubled marks stand for themselves (``{{``, ``[[``, ``%%``), and ``\n`` is a space.
"""

import re

RUBY = r"<(?P<r>rt|rp)\b[^<>]*>.*?</(?P=r)>|\{(?P<s>rt)\}.*?\{/(?P=s)\}"
TAG = r"</?[A-Za-z][^<>]*>|<\d\d[\d:.,]*>"
BRACES = r"\{\{|\}\}|\{[^{}]*\}"
BRACKETS = r"\[\[|\]\]|\[[^\[\]]*(?:\[[^\[\]]*\][^\[\]]*)*\]"
PERCENT = r"%%|%\(\w+\)[-+#0]*\d*(?:\.\d+)?[a-z]|%(?:\d+\$)?[-+#0]*\d*(?:\.\d+)?[sdifuxc@](?!\w)"
DOLLAR = r"\$\{[^{}]*\}|\$[A-Za-z_]\w*"
ESCAPE = r"\\[nrt]|\\(?P<kept>[\\\"'%\[{ ])"
MUSIC = r"[♩♪♫♬]+"

MARKUP = re.compile(
    f"{RUBY}|{DOLLAR}|{TAG}|{BRACES}|{BRACKETS}|{PERCENT}|{ESCAPE}|{MUSIC}", re.DOTALL
)
DOUBLED = {"{{": "{", "}}": "}", "[[": "[", "]]": "]", "%%": "%"}
LOOSE = re.compile(r" ([,.])(?!\S)")
MARKS = frozenset("<{[%$\\}]♩♪♫♬")


def spoken(text: str) -> tuple[str, tuple[str, ...]]:
    """Return what of a text is spoken, and what was dropped, in order."""
    if MARKS.isdisjoint(text):
        return " ".join(text.split()), ()
    dropped: list[str] = []

    def replaced(found: re.Match[str]) -> str:
        whole = found[0]
        if whole in DOUBLED:
            return DOUBLED[whole]
        if whole.startswith("\\"):
            return found["kept"] or " "
        dropped.append(whole)
        return ""

    left = MARKUP.sub(replaced, text)
    return LOOSE.sub(r"\1", " ".join(left.split())), tuple(dropped)
