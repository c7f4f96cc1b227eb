"""What helps people write language packs: drafts, tables, and trials of their tests."""
