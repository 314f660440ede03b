"""The case file: what is measured, compared and sealed."""
