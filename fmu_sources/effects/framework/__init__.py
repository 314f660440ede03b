"""What an effect is: its declaration, its placing in a slot, and the catalogue of all effects."""
