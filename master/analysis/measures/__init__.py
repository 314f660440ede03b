"""Poles, zeros, margins, frequency responses and sweeps."""
