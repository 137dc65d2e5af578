"""Meshes, selections and solids on DOLFINx."""
