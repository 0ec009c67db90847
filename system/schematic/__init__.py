"""A circuit as a schematic: its parts, where they stand, what joins them, and the picture."""
