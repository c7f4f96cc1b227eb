"""Pictures and videos of a performance."""
