"""YAML with positions: text becomes data, each value keeps its line and column for faults."""
