"""The dialects that netlists are written in, one in each file."""
