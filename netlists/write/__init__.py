"""From a testbench to the lines that all dialects share."""
