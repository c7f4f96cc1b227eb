"""Plain texts from templates: reports for people, and drafts of files."""

from collections.abc import Callable, Mapping
from typing import Any


def filled(
    package: str, template: str, values: Mapping[str, object], **filters: Callable[[Any], str]
) -> str:
    """Fill a template in a package's folder; it may use `filters` on its values."""
    from importlib.resources import files

    from jinja2 import Environment, StrictUndefined

    environment = Environment(  # noqa: S701 plain text, no HTML
        undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True
    )
    environment.filters |= filters
    text = (files(package) / f"{template}.jinja").read_text("utf-8")
    return environment.from_string(text).render(values)
