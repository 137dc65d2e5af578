"""Which model a scene requires: candidates, their measurement, and the choice."""
