"""The schedule as a flat program, the loop that executes it, and all that happens between its chunks."""
