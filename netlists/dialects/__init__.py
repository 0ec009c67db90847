"""Dialects of netlists, one a file."""
