"""The process that FMUs run in: which call is going on, signals, and what an FMU may change in it."""
