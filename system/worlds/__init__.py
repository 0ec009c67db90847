"""Worlds: sound, light, and what stands about."""
