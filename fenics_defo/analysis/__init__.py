"""What is computed from a `Solid`: vibration modes, and words for how they move."""
