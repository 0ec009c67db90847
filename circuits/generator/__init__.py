"""The bias generator of a chip: its codes, its circuit, and the voltages of its lines on a die."""
