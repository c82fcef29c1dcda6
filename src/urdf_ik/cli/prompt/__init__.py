"""What is shown and read at the prompt: first steps, completion, help in groups."""
