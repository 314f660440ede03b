"""Design of the phase lead from the plant."""
