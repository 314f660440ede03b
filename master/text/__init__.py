"""Text that people write: YAML with lines, and faults with their places."""
