from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fenics_defo.runtime import Modes

ModesFactory = Callable[..., Modes]


@pytest.fixture
def make_modes() -> ModesFactory:
    """Records with random shapes on two tetrahedra; keywords replace fields."""

    def make(**changes: Any) -> Modes:
        rng = np.random.default_rng(5)
        fields: dict[str, Any] = {
            "frequencies": np.array([0.0, 1.5, 1.5, 40.0]),
            "shapes": rng.normal(size=(4, 8, 3)),
            "points": rng.normal(size=(8, 3)),
            "cells": np.array([[0, 1, 2, 3], [4, 5, 6, 7]]),
            "cell_type": "tetra",
            "node_numbers": np.array([3, 1, 2, 4, 5, 9, 8, 0]),
            "node_mass": rng.uniform(0.5, 1.0, size=8),
            "residuals": rng.uniform(size=4) * 1e-12,
            "rigid_modes": 1,
            "complete": True,
            "participation": rng.normal(size=(4, 6)),
            "total_mass": 6.0,
            "centre": rng.normal(size=3),
            "inertia": rng.uniform(0.5, 1.0, size=6),
        }
        return Modes(**(fields | changes))

    return make
