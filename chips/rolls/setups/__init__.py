"""Set-ups that show what a ROLLS chip does."""
