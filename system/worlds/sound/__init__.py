"""Sound: targets, echoes, and what reaches a microphone."""
