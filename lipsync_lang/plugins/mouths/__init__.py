"""Mouths that a viewer sees: of words on a new head, and of banks that move to another face."""
