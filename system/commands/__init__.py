"""What the commands of `noctule` do, one a file."""
