"""The page: a coverage document as one HTML file to send to a producer.

Everything is written here, once: the first report stands in the page, so that it can be read
without a script, and what other reports have in its place lies beside it in templates. Parts that
reports share, such as a language's ranking for every character, are written once. What differs
between characters are the states of bigrams: a digit each, which the script puts in.

The page asks nobody for anything: its policy forbids that to the browser.
"""

from lipsync_lang.coverage.page.whole import page

__all__ = ["page"]
