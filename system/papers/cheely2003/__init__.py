"""Cheely & Horiuchi 2003: analog VLSI models of range-tuned neurons."""
