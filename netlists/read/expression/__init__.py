"""Expressions of a netlist: their arithmetic, and the parameters that they can use."""
