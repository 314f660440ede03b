"""Methods of compensation side by side: the same cells, the same noise, the same start."""
