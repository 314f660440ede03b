"""The report of a diagnosis: one page, and its panels as PNG."""
