"""Scenes for small robots."""
