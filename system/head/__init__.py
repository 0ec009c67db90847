"""Head: two ears on a servo neck that turn to a target."""
