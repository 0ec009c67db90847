"""From the text of a netlist to its cards and sections."""
