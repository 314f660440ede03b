"""The force sensor: lag, offset and noise."""

RELEASED = True
