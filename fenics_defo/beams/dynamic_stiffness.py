"""Exact frequencies of bars and beams by counting, so that none is missed.

Along a uniform piece the state (displacements d, internal forces f) obeys the linear system
y' = A(omega) y, so exp(A l) gives the exact dynamic stiffness K(omega) of a piece of length l. The
number of frequencies below omega is

    J(omega) = J_clamped + number of negative eigenvalues of K with the supports applied,

where J_clamped counts the frequencies of the pieces with all their end nodes held (Wittrick and
Williams, Q. J. Mech. Appl. Math. 24 (1971) 263). A piece short against the shortest wave has none;
longer ones are two shorter ones joined end to end, each joint adding the negative eigenvalues of
its own block. One rule thus serves bars, Euler-Bernoulli and Timoshenko beams, below and above the
cut-off frequency, uniform or stepped; nothing overflows, and J is narrowed down for every
frequency. They are right to about 1e-13, or 1e-9 where a part between two joints happens to
resonate, held at its ends, at just that frequency.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fenics_defo.beams.pieces import Piece
from fenics_defo.beams.supports import Supports

type Array = NDArray[np.float64]
type Counts = NDArray[np.int64]

# The two sweeps from the supports meet inside a piece. At the beam's ends, or at its middle, the
# held parts would resonate exponentially close to the whole (free-free and clamped-clamped beams
# even share their frequencies), and the stiffness would be a difference of infinities.
_MEETING_POINT = 0.3819660112501051

# With wave number times length <= 1 the eigenvalues of A l are at most 1 in modulus: 1/25! is far
# below round-off.
_TAYLOR_TERMS = 24

# Many trial frequencies at once cost little more than one: three bits a pass.
_SECTIONS = np.linspace(0.0, 1.0, 9)

_SIGNS = {1: np.ones((1, 1)), 2: np.array([[1.0, -1.0], [1.0, 1.0]])}


@dataclass(frozen=True, slots=True)
class _Member:
    """Stiffness between two nodes of p displacements each, at k trial frequencies.

    Args:
        near: block of the first node, (k, p, p).
        cross: forces of the first node due to the second's displacements, (k, p, p).
        far: block of the second node, (k, p, p).
        clamped: frequencies below each trial one with both nodes held, (k,).
        transfer: exp(A l), (k, 2 p, 2 p), of use where the member is short.
        short: whether wave number times length is at most 1, (k,).
    """

    near: Array
    cross: Array
    far: Array
    clamped: Counts
    transfer: Array
    short: NDArray[np.bool_]

    def turned(self) -> "_Member":
        """The same member seen from its other end."""
        size = self.near.shape[-1]
        turned = self.transfer.copy()
        turned[..., :size, :size] = _transposed(self.transfer[..., size:, size:])
        turned[..., size:, size:] = _transposed(self.transfer[..., :size, :size])
        turned[..., :size, size:] = _transposed(self.transfer[..., :size, size:])
        turned[..., size:, :size] = _transposed(self.transfer[..., size:, :size])
        return replace(
            self, near=self.far, cross=_transposed(self.cross), far=self.near, transfer=turned
        )


def natural_frequencies(pieces: Sequence[Piece], supports: Supports, *, count: int) -> Array:
    """Lowest natural frequencies of pieces joined end to end.

    Args:
        pieces: all of one kind, in order along the axis.
        supports: of the first piece's near end and the last one's far end.
        count: how many frequencies to return.

    Returns:
        Frequencies [Hz], (count,), ascending, each as often as its multiplicity; the zero
        frequencies of rigid motions left out.
    """
    wanted = supports.rigid + 1 + np.arange(count)
    low, high = np.zeros(count), np.ones(count)
    while np.any(short := count_below(pieces, supports, omega=high) < wanted):
        low, high = np.where(short, high, low), np.where(short, 8.0 * high, high)
    while np.any(high - low > 4.0 * np.finfo(float).eps * high):
        trials = low[:, None] + (high - low)[:, None] * _SECTIONS
        counts = count_below(pieces, supports, omega=trials[:, 1:-1].ravel())
        # The wanted count is passed between the last trial below it and the next one.
        cell = np.sum(counts.reshape(count, -1) < wanted[:, None], axis=1)
        low, high = trials[np.arange(count), cell], trials[np.arange(count), cell + 1]
    return (low + high) / (4.0 * np.pi)


def count_below(pieces: Sequence[Piece], supports: Supports, *, omega: Array) -> Counts:
    """J: the number of natural frequencies below each angular frequency ``omega`` [rad/s], (k,).

    Rigid motions count.
    """
    longest = int(np.argmax([p.length * float(p.wave_number(np.array(1.0))) for p in pieces]))
    meet = pieces[longest]
    shares = (_MEETING_POINT * meet.length, (1.0 - _MEETING_POINT) * meet.length)
    ahead, behind = (_uniform(replace(meet, length=share), omega) for share in shares)
    left = [*(_uniform(piece, omega) for piece in pieces[:longest]), ahead]
    right = [*(_uniform(piece, omega).turned() for piece in pieces[:longest:-1]), behind.turned()]
    left_stiffness, left_count = _fold(left, supports.held[0])
    right_stiffness, right_count = _fold(right, supports.held[1])
    return left_count + right_count + _negatives(left_stiffness + right_stiffness)


def _uniform(piece: Piece, omega: Array) -> _Member:
    """A uniform piece at (k,) frequencies, grown by doubling from a part with no clamped mode.

    Below the cut-off, kl <= 1 < pi leaves even the pinned part without a mode. Above it, k exceeds
    both omega / c_shear and omega / c_bar, and (w' - psi)^2 >= w'^2 / 2 - psi^2 with Poincare's
    inequality for w and psi shows that the clamped part has none either.
    """
    waves = piece.wave_number(omega) * piece.length
    doublings = np.ceil(np.log2(np.maximum(waves, 1.0))).astype(np.int64)
    member = _short(piece, omega, piece.length * np.exp2(-doublings.astype(np.float64)))
    for step in range(int(doublings.max(initial=0))):
        grow = doublings > step
        near, cross, far, clamped = _doubled(
            member.near[grow], member.cross[grow], member.far[grow], member.clamped[grow]
        )
        member.near[grow], member.cross[grow], member.far[grow] = near, cross, far
        member.clamped[grow], member.short[grow] = clamped, False
    return member


def _short(piece: Piece, omega: Array, length: Array) -> _Member:
    """Exact member from the Taylor series of exp(A l), all waves being longer than 2 pi l."""
    step = piece.system(omega) * length[:, None, None]
    identity = np.broadcast_to(np.eye(step.shape[-1]), step.shape)
    transfer = identity.copy()
    for term in range(_TAYLOR_TERMS, 0, -1):  # Horner
        transfer = identity + step @ transfer / term
    size = step.shape[-1] // 2
    stretch, give = transfer[..., :size, :size], transfer[..., :size, size:]
    cross = -_inverse(give, give)
    near = -cross @ stretch
    far = -transfer[..., size:, size:] @ cross
    return _Member(
        _symmetric(near),
        cross,
        _symmetric(far),
        clamped=np.zeros(omega.shape, dtype=np.int64),
        transfer=transfer,
        short=np.ones(omega.shape, dtype=np.bool_),
    )


def _fold(members: Sequence[_Member], held: Sequence[int]) -> tuple[Array, Counts]:
    """Members in a row, the first resting on a support, condensed to the last node.

    Returns:
        Stiffness (k, p, p) at the free node of the last member, and the number (k,) of
        frequencies below the trial ones with that node held.
    """
    size = members[0].near.shape[-1]
    free = [i for i in range(size) if i not in held]
    count, stiffness = members[0].clamped, members[0].far
    if free:
        near, cross = members[0].near[..., free, :][..., free], members[0].cross[..., free, :]
        inverse = _inverse(near, cross[..., free])
        stiffness = stiffness - _transposed(cross) @ inverse @ cross
        count = count + _negatives(near)
    moves = np.diag([float(i in free) for i in range(size)])
    stiffness = _carried(members[0], moves, np.eye(size) - moves, stiffness)
    for member in members[1:]:
        joint = stiffness + member.near
        inverse = _inverse(joint, member.cross)
        condensed = member.far - _transposed(member.cross) @ inverse @ member.cross
        stiffness = _carried(member, np.eye(size), stiffness, condensed)
        count = count + member.clamped + _negatives(joint)
    return stiffness, count


def _carried(member: _Member, moves: Array, forces: Array, condensed: Array) -> Array:
    """Stiffness at a member's far node, from near-node states with these columns.

    ``condensed`` is the same by condensation, which long members need. In a short member it is a
    small difference of large numbers: a stiff head on a soft beam would lose its mass.
    """
    size = member.near.shape[-1]
    top, bottom = member.transfer[..., :size, :], member.transfer[..., size:, :]
    motion = top[..., :size] @ moves + top[..., size:] @ forces
    force = bottom[..., :size] @ moves + bottom[..., size:] @ forces
    by_transfer = force @ _inverse(motion, top[..., size:])
    return _symmetric(np.where(member.short[:, None, None], by_transfer, condensed))


def _doubled(
    near: Array, cross: Array, far: Array, clamped: Counts
) -> tuple[Array, Array, Array, Counts]:
    """Two equal members end to end, their common node condensed and counted."""
    joint = far + near
    inverse = _inverse(joint, cross)
    back, ahead = inverse @ _transposed(cross), inverse @ cross
    return (
        _symmetric(near - cross @ back),
        -cross @ ahead,
        _symmetric(far - _transposed(cross) @ ahead),
        2 * clamped + _negatives(joint),
    )


def _transposed(blocks: Array) -> Array:
    return blocks.swapaxes(-1, -2)


def _symmetric(blocks: Array) -> Array:
    return 0.5 * (blocks + _transposed(blocks))


def _determinant(blocks: Array) -> Array:
    if blocks.shape[-1] == 1:
        return blocks[..., 0, 0]
    return blocks[..., 0, 0] * blocks[..., 1, 1] - blocks[..., 0, 1] * blocks[..., 1, 0]


def _size(blocks: Array) -> Array:
    """The determinant of 1x1 or 2x2 blocks with every sign made positive."""
    return _determinant(np.abs(blocks) * _SIGNS[blocks.shape[-1]])


def _inverse(blocks: Array, coupling: Array) -> Array:
    """Inverse of 1x1 or 2x2 blocks; by formula, so that mixed units (m, rad) cost no accuracy.

    Bisection may land where a block is exactly singular, on a frequency of the held part. Round-off
    of its own size and of the ``coupling`` blocks' then takes the place of the determinant, which
    is a step to one side of that frequency.
    """
    determinant = _determinant(blocks)
    floor = np.finfo(float).eps * (_size(blocks) + _size(coupling))
    determinant = np.where(determinant == 0.0, floor, determinant)[..., None, None]
    if blocks.shape[-1] == 1:
        return 1.0 / determinant
    adjugate = np.empty_like(blocks)
    adjugate[..., 0, 0], adjugate[..., 1, 1] = blocks[..., 1, 1], blocks[..., 0, 0]
    adjugate[..., 0, 1], adjugate[..., 1, 0] = -blocks[..., 0, 1], -blocks[..., 1, 0]
    return adjugate / determinant


def _negatives(blocks: Array) -> Counts:
    """Negative eigenvalues of symmetric 1x1 or 2x2 blocks, free of scaling."""
    determinant, corner = _determinant(blocks), blocks[..., 0, 0]
    paired = np.where(corner < 0.0, blocks.shape[-1], 0)
    if blocks.shape[-1] == 1:
        return paired
    return np.where(determinant < 0.0, 1, paired)
