"""The text of a netlist and the cards and sections that it consists of."""
