"""What a ROLLS chip's step knows of its devices: networks at rest, filters and neurons as tables."""
