"""Verilog-A: circuits and behavioural cells."""
