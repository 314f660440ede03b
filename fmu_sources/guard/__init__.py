"""The guard of a rig: it watches the motion, and holds it where it gains energy or leaves its limits."""

RELEASED = False
