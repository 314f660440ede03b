"""Recordings: tables, units, signals."""
