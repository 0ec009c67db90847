"""What a user asks for as text, made into parameters, biases, stimuli and silicon."""
