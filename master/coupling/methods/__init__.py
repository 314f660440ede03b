"""Coupling methods, one a file: each module here that defines a `Method` is found by the catalogue."""
