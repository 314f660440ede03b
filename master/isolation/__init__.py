"""FMUs in processes of their own: they step as any other one does, and take nobody with them."""
