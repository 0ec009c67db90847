"""Circuits of PySpice, written and read."""
