"""The compensator of the paper."""

RELEASED = True
