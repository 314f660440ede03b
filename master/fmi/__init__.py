"""FMUs: what their descriptions say, and how FMI 2.0 and 3.0 are called."""
