"""HTML that cannot be wrong: every text is escaped, every element is closed."""

from collections.abc import Callable, Iterable
from html import escape

VOID = {"br", "col", "input", "link", "meta"}
"""Elements without an end."""


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


Child = str | int | Iterable["Child"]
"""What an element holds: text, a number, markup, or several of them."""


class _Tags:
    """Makes elements: `tags.p("a < b", class_="note", hidden=True)`.

    An underscore within an attribute's name is a hyphen, one at its end is dropped; attributes
    that are None or False are left out.
    """

    def __getattr__(self, name: str) -> Callable[..., Markup]:
        def make(*children: Child, **attributes: str | int | bool | None) -> Markup:
            start = name + "".join(_attribute(key, value) for key, value in attributes.items())
            end = "" if name in VOID else f"</{name}>"
            return Markup(f"<{start}>{join(*children)}{end}")

        return make


tags = _Tags()


def join(*children: Child) -> Markup:
    """Put children after each other, escaping all that is not markup."""
    return Markup("".join(map(_text, children)))


def _text(child: Child) -> str:
    if isinstance(child, Markup):
        return child
    if isinstance(child, (str, int)):
        return escape(str(child))
    return join(*child)


def _attribute(name: str, value: str | int | bool | None) -> str:  # noqa: FBT001 HTML has such
    key = name.rstrip("_").replace("_", "-")
    if value is None or value is False:
        return ""
    return f" {key}" if value is True else f' {key}="{escape(str(value))}"'
