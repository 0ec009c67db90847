"""Circuits written to PySpice and taken over from it."""
