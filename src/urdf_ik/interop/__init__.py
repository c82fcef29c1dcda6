"""Solutions as differentiable functions of torch and of jax."""
