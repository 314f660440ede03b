"""Models with effects in their slots: how they are composed, named and found."""
