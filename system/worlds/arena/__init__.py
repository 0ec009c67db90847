"""Scenes for small robots: what stands in an arena, how it moves, and what a robot touches."""
