"""The benchmark of real-time hybrid simulation: a building of three floors, one of its columns on a rig."""

RELEASED = False
