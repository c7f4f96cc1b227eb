"""Pictures of a performance."""
