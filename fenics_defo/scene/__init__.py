"""Scenes: what a TOML file says, and its simulation."""
