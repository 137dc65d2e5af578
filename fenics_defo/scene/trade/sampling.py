"""When motions are compared: at times that all candidates' steps come to."""

from dataclasses import dataclass

from fenics_defo.scene.records import Scene

# Compared states, and the memory that those of the reference may take [bytes].
_STATES, _MEMORY, _FEWEST = 200, 400e6, 10


@dataclass(frozen=True, slots=True)
class Sampling:
    """Times of comparison: the start and every ``stride`` steps of the scene.

    Args:
        step: of the scene [s].
        steps: of the scene.
        stride: steps from one state to the next.
    """

    step: float
    steps: int
    stride: int

    @property
    def count(self) -> int:
        """Number of states, that at the start among them."""
        return 1 + self.steps // self.stride

    @property
    def times(self) -> tuple[float, ...]:
        """Times of the states [s]."""
        return tuple(number * self.stride * self.step for number in range(self.count))


def sampling(scene: Scene, nodes: int, factors: tuple[int, ...]) -> Sampling:
    """The times at which motions of a scene are compared.

    Args:
        scene: scene.
        nodes: number of them.
        factors: of the scene's step that are tried.
    """
    steps, coarsest = scene.time.steps, max(factors)
    most = max(_FEWEST, min(_STATES, int(_MEMORY / (24.0 * nodes))))
    return Sampling(scene.time.step, steps, coarsest * max(1, -(-steps // (coarsest * most))))
