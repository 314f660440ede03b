"""From a file and a request to a system that is ready to step."""
