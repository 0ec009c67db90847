"""Isolation of the first target: only the first echo of a call passes."""
