"""Runs that have names on disk: made into a folder, described by a manifest, repeated, compared."""
