"""What the ends of a beam or bar may do, and the rigid motions that they leave."""

from dataclasses import dataclass

from fenics_defo.beams.checks import BeamError

# Displacements held at an end: 0 the deflection (of a bar, its one displacement), 1 the rotation.
_BEAM_ENDS: dict[str, tuple[int, ...]] = {
    "clamped": (0, 1),
    "pinned": (0,),
    "sliding": (1,),
    "free": (),
}
_BAR_ENDS: dict[str, tuple[int, ...]] = {"fixed": (0,), "free": ()}


@dataclass(frozen=True, slots=True)
class Supports:
    """Both ends of a beam or bar.

    Args:
        kinds: the word for each end.
        held: the displacements held at each end.
        rigid: how many rigid motions are left.
    """

    kinds: tuple[str, str]
    held: tuple[tuple[int, ...], tuple[int, ...]]
    rigid: int


def beam_supports(supports: str) -> Supports:
    """Supports of a beam in one plane.

    Args:
        supports: two of "clamped", "pinned", "sliding", "free" with a hyphen, as "clamped-free".

    Raises:
        BeamError: another word, or not two of them.
    """
    first, last = _parse("supports", supports, _BEAM_ENDS)
    held = (_BEAM_ENDS[first], _BEAM_ENDS[last])
    deflections = sum(0 in end for end in held)
    turns = not any(1 in end for end in held)
    # Rigid motions are a shift and a turn; a held rotation stops the turn alone.
    rigid = 2 - deflections if turns else int(deflections == 0)
    return Supports((first, last), held, rigid)


def bar_supports(ends: str) -> Supports:
    """Supports of a bar in tension or torsion, from two of "fixed", "free" with a hyphen.

    Raises:
        BeamError: another word, or not two of them.
    """
    first, last = _parse("ends", ends, _BAR_ENDS)
    held = (_BAR_ENDS[first], _BAR_ENDS[last])
    return Supports((first, last), held, 0 if any(held) else 1)


def _parse(name: str, value: str, ends: dict[str, tuple[int, ...]]) -> tuple[str, str]:
    words = value.split("-") if isinstance(value, str) else []
    if len(words) != 2 or any(word not in ends for word in words):
        example = "-".join((next(iter(ends)), "free"))
        raise BeamError(
            f"{name} must be two of {', '.join(ends)} with a hyphen, such as {example!r}; "
            f"got {value!r}"
        )
    return words[0], words[1]
