"""Self-contained HTML pages from templates: one style, and files of their own inside.

Pages load no other files; their content security policy forbids it.
"""

import re
from base64 import b64encode
from collections.abc import Mapping
from functools import partial
from hashlib import sha256

from jinja2 import ChoiceLoader, Environment, PackageLoader, PrefixLoader, StrictUndefined
from jinja2.ext import Extension
from markupsafe import Markup

from lipsync_lang.base.errors import count
from lipsync_lang.base.files.quoting import xml_text
from lipsync_lang.base.presentation.wording import NBSP

CHART_HEIGHT = 1000
"""Height of a chart in its own units; it stretches."""


class TightLayout(Extension):
    """Pattern of a line break next to a tag or a block, with its indentation."""

    def preprocess(self, source: str, name: str | None, filename: str | None = None) -> str:
        """Remove these line breaks from a template."""
        # Comments keep the breaks, so that Jinja's errors name the right line.
        del name, filename
        return re.sub(r"(?<=[>}])\s*\n\s*|\s*\n\s*(?=[<{])", r"{#\g<0>#}", source)


class PageEnvironment(Environment):
    """Templates in a folder of a package; in them, `reports/` names those that all pages share."""

    def __init__(self, package: str, folder: str) -> None:
        self._files = PackageLoader(package, folder)
        self._shared = PackageLoader(__package__)
        super().__init__(
            autoescape=True,
            extensions=[TightLayout],
            loader=ChoiceLoader([self._files, PrefixLoader({"reports": self._shared})]),
            undefined=StrictUndefined,
        )
        self.filters["commas"] = "{:,}".format
        self.globals["count"] = partial(count, space=NBSP)

    def page(
        self, template: str, values: Mapping[str, object], style: str = "", script: str = ""
    ) -> str:
        """Return a page with common styles and its own, and the only script that it may run.

        The template gets the values, and `style`, `script` and its `digest`. Characters that HTML
        cannot hold, such as NUL, are replaced.
        """
        styles, scripts = self._source(self._shared, "style.css"), ""
        if style:
            styles += self._source(self._files, style)
        if script:
            scripts = self._source(self._files, script)
        # The policy of the page allows the script of this digest, and no other.
        digest = b64encode(sha256(scripts.encode()).digest()).decode()
        page = self.get_template(template).render(
            values,
            style=Markup(styles),  # noqa: S704 our own
            script=Markup(scripts),  # noqa: S704 our own
            digest=Markup(f"sha256-{digest}"),  # noqa: S704 base64
        )
        return xml_text(page)

    def _source(self, loader: PackageLoader, name: str) -> str:
        return loader.get_source(self, name)[0]
