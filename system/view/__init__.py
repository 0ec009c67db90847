"""A run as a film: what it shows over time, a page that plays it, and a file that keeps it."""
