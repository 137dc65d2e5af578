"""Choosing few points and weights at which any energy's reduced force is summed."""
