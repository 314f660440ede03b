"""Laws learned from data where no listed effect fits."""
