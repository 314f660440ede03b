"""What is done before a rig is switched on: it is measured, and judged for every plant that it may be."""
