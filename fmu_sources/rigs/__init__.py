"""Small models of the rigs that measured data come from."""

RELEASED = False
