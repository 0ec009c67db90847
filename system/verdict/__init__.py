"""What the rows of an experiment say together: beside nulls, and as a family of tests."""
