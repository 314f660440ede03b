"""Systems as SSP 1.0 archives: written from a checked system, read back as a configuration."""
