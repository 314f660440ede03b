"""Calls and memory of C functions, for Python and for compiled code."""
