"""The motion simulator: a hexapod, and one linear axis."""

RELEASED = True
