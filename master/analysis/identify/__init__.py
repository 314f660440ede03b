"""Linear systems identified from responses of FMUs."""
