"""The docking of the two bodies in space, for comparison."""

RELEASED = True
