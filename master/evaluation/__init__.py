"""What a run means: metrics, modes, plots, the summary."""
