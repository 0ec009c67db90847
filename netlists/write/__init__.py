"""The way from a testbench to the lines of a netlist, as far as all dialects share it."""
