"""What families share: plans, the elimination's set-up, explanations."""
