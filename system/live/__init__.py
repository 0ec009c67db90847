"""What a robot in its world is that goes on by one action at a time."""
