"""Harnesses of `docs/reliability.md`, run on demand."""
