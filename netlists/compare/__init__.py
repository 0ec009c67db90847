"""Whether two circuits are the same."""
