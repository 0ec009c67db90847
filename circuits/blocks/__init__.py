"""Circuits that the command line knows by a name, one in each file: sizes, biases, testbench and measures."""
