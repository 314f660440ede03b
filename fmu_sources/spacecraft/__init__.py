"""The mass of the spacecraft."""

RELEASED = True
