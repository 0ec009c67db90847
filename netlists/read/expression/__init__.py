"""Expressions of netlists: arithmetic, and the parameters in reach."""
