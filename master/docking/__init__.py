"""What the master knows of the docking models by their names: phase lead, form of the plant."""
