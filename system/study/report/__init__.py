"""What a finished study has to tell."""
