"""A docking test rig in software: systems of FMUs from Python."""
