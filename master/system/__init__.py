"""The YAML file and the graph of instances, ports and wires it describes; no FMU is loaded."""
