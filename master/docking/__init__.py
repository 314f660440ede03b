"""What the master knows of the docking models by their names: conventions, phase lead, form of the plant."""
