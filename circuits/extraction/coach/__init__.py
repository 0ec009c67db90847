"""Measurements of a teaching chip, and the fit of a process and of one die to them."""
