"""Circuits of the ROLLS chip."""
