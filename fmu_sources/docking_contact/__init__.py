"""The contact of drag mechanism, rope and manipulator."""

RELEASED = True
