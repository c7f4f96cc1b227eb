"""Authoring aids for packs: drafts, imports, tables and test runs."""
