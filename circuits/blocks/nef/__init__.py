"""Circuits of the NEF chip."""
