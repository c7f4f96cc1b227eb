"""The page: a coverage document as one HTML file for a producer.

The page contains the first report, which is readable without a script; the parts of other reports
are in `<template>` elements. A part that several reports share, such as a language's ranking for
every character, is written once. Characters differ in the states of bigrams: one digit each, which
the script inserts.

The page loads no other files; its content security policy forbids it.
"""

from lipsync_lang.reports.coverage.page.assembling import page

__all__ = ["page"]
