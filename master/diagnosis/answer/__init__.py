"""Before and after on sealed rows, corrected FMUs, and the report."""
