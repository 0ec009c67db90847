"""Bug: a robot with a compass and a contact sensor among obstacles."""
