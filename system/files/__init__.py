"""Files: written whole, claimed by one process, and read against a schema."""
