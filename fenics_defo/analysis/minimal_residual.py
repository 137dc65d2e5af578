"""Systems whose matrix is almost the identity."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def minimal_residual(
    operate: Callable[[Array], Array],
    right_side: Array,
    *,
    product: Callable[[Array, Array], float],
    tolerance: float,
    most: int,
) -> Array:
    """Solve B x = b by GMRES; collective if ``product`` is.

    Args:
        operate: B times a field.
        right_side: b.
        product: scalar product of two fields.
        tolerance: ‖b - B x‖ / ‖b‖ at which it stops.
        most: largest number of products with B; what is best then is taken.

    References: Saad and Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856-869.
    """
    norm = float(np.sqrt(product(right_side, right_side)))
    if not (norm > 0.0 and np.isfinite(norm)):
        return right_side
    basis = [right_side / norm]
    table = np.zeros((most + 1, most))
    target = np.zeros(most + 1)
    target[0] = norm
    for column in range(most):
        image = operate(basis[-1])
        for row, other in enumerate(basis):
            table[row, column] = product(other, image)
            image = image - table[row, column] * other
        rest = float(np.sqrt(product(image, image)))
        table[column + 1, column] = rest
        part = table[: column + 2, : column + 1]
        weights = np.linalg.lstsq(part, target[: column + 2], rcond=None)[0]
        missing = float(np.linalg.norm(part @ weights - target[: column + 2]))
        if not missing > tolerance * norm or rest == 0.0:
            break
        basis.append(image / rest)
    solution = np.zeros_like(right_side)
    for weight, field in zip(weights, basis, strict=False):
        solution += weight * field
    return solution
