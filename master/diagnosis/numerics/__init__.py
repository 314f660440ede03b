"""Numerical methods of the diagnosis: they know arrays only."""
