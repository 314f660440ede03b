"""Methods of delay compensation: one a file, all with the same plugs."""

RELEASED = False
