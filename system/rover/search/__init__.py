"""Conventional searches for paths on a cost map."""
