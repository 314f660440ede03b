"""Rows of a run, in memory and in files."""
