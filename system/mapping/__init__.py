"""Networks that are put on a chip: what a network is, what a chip makes of it, and how far apart both are."""
