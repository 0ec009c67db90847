"""Dies as files, and dies that are edited."""
