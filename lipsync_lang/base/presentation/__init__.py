"""Parts that reports of all rooms share: HTML pages, JUnit XML, tables of text, and wording."""
