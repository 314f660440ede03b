"""Quantities that claims are judged by, from runs and from poles."""
