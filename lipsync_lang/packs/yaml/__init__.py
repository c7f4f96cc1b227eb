"""YAML with positions: text to data, where each value stands, and faults that say so."""
