"""Circuits of the wavefront chip."""
