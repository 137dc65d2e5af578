"""Independent approximations of the beams under test: Ritz bases and Hermite finite elements."""

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh, null_space


def ritz_timoshenko(piece, held, *, degree):
    """Frequencies [Hz] of one BeamPiece from Legendre polynomials for deflection and rotation.

    Upper bounds, and of spectral accuracy in the lower half.
    """
    x, w = legendre.leggauss(degree + 2)
    w = 0.5 * w * piece.length
    values = legendre.legvander(x, degree)
    slopes = np.stack(
        [legendre.legval(x, legendre.legder(c)) for c in np.eye(degree + 1)], axis=1
    ) * (2.0 / piece.length)
    zero = np.zeros_like(values)
    w_val, p_val = np.hstack([values, zero]), np.hstack([zero, values])
    shear = np.hstack([slopes, -values])
    bend = np.hstack([zero, slopes])

    def gram(rows, factor):
        return factor * rows.T @ (w[:, None] * rows)

    stiffness = gram(bend, piece.bending_stiffness) + gram(shear, 1.0 / piece.shear_flexibility)
    mass = gram(w_val, piece.mass) + gram(p_val, piece.rotary_inertia)
    ends = legendre.legvander(np.array([-1.0, 1.0]), degree)
    rows = [
        np.concatenate([ends[e] * (part == 0), ends[e] * (part == 1)])
        for e in (0, 1)
        for part in held[e]
    ]
    free = null_space(np.array(rows)) if rows else np.eye(2 * degree + 2)
    squares = eigh(free.T @ stiffness @ free, free.T @ mass @ free, eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)


def hermite_frequencies(pieces, held, *, elements):
    """Frequencies [Hz] of Euler-Bernoulli pieces from cubic elements, ``elements`` a piece."""
    nodes = elements * len(pieces) + 1
    stiffness, mass = np.zeros((2, 2 * nodes, 2 * nodes))
    node = 0
    for piece in pieces:
        h = piece.length / elements
        k = np.array(
            [
                [12, 6 * h, -12, 6 * h],
                [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                [-12, -6 * h, 12, -6 * h],
                [6 * h, 2 * h * h, -6 * h, 4 * h * h],
            ]
        ) * (piece.bending_stiffness / h**3)
        m = np.array(
            [
                [156, 22 * h, 54, -13 * h],
                [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                [54, 13 * h, 156, -22 * h],
                [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
            ]
        ) * (piece.mass * h / 420.0)
        for _ in range(elements):
            dofs = slice(2 * node, 2 * node + 4)
            stiffness[dofs, dofs] += k
            mass[dofs, dofs] += m
            node += 1
    fixed = [*held[0], *(2 * (nodes - 1) + part for part in held[1])]
    free = np.setdiff1d(np.arange(2 * nodes), fixed)
    squares = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)
