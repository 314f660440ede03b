"""Search for the effects that explain a residual."""
