"""Models stepped over measured inputs."""
