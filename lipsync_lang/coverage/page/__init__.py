"""The page: a coverage document as one HTML file to send to a producer.

The first report stands in the page, so that it can be read without a script; the parts of other
reports lie beside it in `<template>` elements. A part that reports share, such as a language's
ranking for every character, is written once. Characters differ in the states of bigrams: a digit
each, which the script puts in.

The page loads nothing: its content security policy forbids that to the browser.
"""

from lipsync_lang.coverage.page.assembling import page

__all__ = ["page"]
