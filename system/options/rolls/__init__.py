"""What systems with a ROLLS chip have in common: its process, and its power in a run."""
