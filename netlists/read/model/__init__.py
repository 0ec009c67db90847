"""Elements whose figures stand in a `.model` card of their own."""
