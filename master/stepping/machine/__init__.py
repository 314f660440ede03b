"""The flat program and the one loop that executes it."""
