"""Names of languages as people write them, in one form for comparison."""

import re
from unicodedata import combining, normalize

_JOINTS = re.compile(r"[\s_-]+")


def folded_language(name: str) -> str:
    """Return a name in small letters without accents, its words joined by hyphens.

    >>> folded_language("Português_Brasil "), folded_language("zh-Hans")
    ('portugues-brasil', 'zh-hans')
    """
    small = name.strip().casefold()
    if not small.isascii():
        small = "".join(c for c in normalize("NFKD", small) if not combining(c))
    return _JOINTS.sub("-", normalize("NFC", small))
