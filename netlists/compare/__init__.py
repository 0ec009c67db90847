"""Comparison of two circuits: whether they are the same, whatever their names and their order."""
