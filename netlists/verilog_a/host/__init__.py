"""Compact models in Verilog-A, compiled by OpenVAF, as the transistors of a circuit."""
