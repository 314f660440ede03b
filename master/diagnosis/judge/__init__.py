"""Evidence, refit and verdict of a part."""
