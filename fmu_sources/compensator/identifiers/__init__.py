"""Where the process parameters come from: one identifier a file."""
