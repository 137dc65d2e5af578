"""Geometry scripts: each module holds one body for gmsh, to import or to run as a script."""
