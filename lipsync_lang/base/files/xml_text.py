"""Text for XML, which cannot hold every character."""

import re

# what is forbidden, for a pattern of what is allowed takes 10 ms to compile
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def xml_text(text: str) -> str:
    """Return text with a replacement character for each character that XML 1.0 forbids."""
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)
