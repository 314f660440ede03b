"""One FMU from a coupled system: the sources of its FMUs and the schedule, compiled together."""
