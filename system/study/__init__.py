"""Studies: one engine for Monte Carlo and campaigns, what it measures, and its files."""
