"""What a chip's step knows of its devices: small networks at rest, filters and neurons as tables."""
