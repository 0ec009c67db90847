"""Circuits of a teaching chip in 0.18 um, with its sizes, on testbenches like those of its laboratory."""
