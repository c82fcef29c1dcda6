"""Cuspidality: whether an arm can change from one solution of a pose to another without crossing a singularity.

Not cuspidal, by proof: an arm whose solver takes the joint angles from the roots of quadratics, one step after the
other. The Jacobian's determinant is then, but for factors that never vanish, the product of the steps' derivatives,
and the two roots of a step have derivatives of opposite sign. On a path without a singularity no factor changes its
sign, so in the pose that it began with, it ends at the same root of every step.

Cuspidal, by a path: two solutions of one pose, joined by moves of one joint at a time along which the determinant keeps
its sign. Joints 1 and 6 have no part in it. Along any other joint the determinant is a trigonometric polynomial of
degree two (the turn acts on the axes behind it as a rotation R on directions and moments alike, and the minors of
diag(R, R) hold no higher harmonic), so five values give it on the whole circle, and its second derivative bounds what
happens between samples. The path is looked for on a grid over the joints 2 to 5. Joint limits are left aside.

Not finding a path proves nothing. Sources: Wenger, A new general formalism for the kinematic analysis of all
nonredundant manipulators, 1992; Wenger and Chablat 2022; Salunkhe et al. 2022 (a generic 3R arm is cuspidal if and only
if it has a cusp).
"""

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array

_MOVING = (1, 2, 3, 4)
_NODES = 16  # along each of these joints
_SHAPE = (_NODES,) * 4
_FINER = 8  # samples from node to node
_SPACING = 2.0 * np.pi / _NODES
_POSES = 100
_CLEAR, _LEAST = 1e-9, 1e-12  # of the polynomial's greatest coefficient, and as it stands: less is rounding
_DISTINCT = 1e-3  # rad


def is_cuspidal(solver: Solver) -> bool | None:
    """Whether an arm can change solutions without crossing a singularity; None if unknown.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> is_cuspidal(arm.solver)
        False
    """
    structure = solver.structure
    if not structure.is_6r or not structure.family or solver.chain.axes is not solver.chain:
        return None
    if structure.by_quadratics:
        return False
    return True if nonsingular_change(solver) is not None else None


def in_words(cuspidal: bool | None) -> str:
    """The text that follows "cuspidal" in reports: yes, no or not known, with the meaning."""
    if cuspidal is None:
        return "not known: no change of solution around the singularities was found, which does not rule one out"
    if cuspidal:
        return "yes: limits aside, it can change from one solution of a pose to another without crossing a singularity"
    return "no: every change from one solution of a pose to another crosses a singularity"


def nonsingular_change(solver: Solver) -> Array | None:
    """A path that proves an arm of six turning joints cuspidal.

    Args:
        solver: of an arm of six turning joints.

    Returns:
        (k, 6) rad, joint vectors from one solution of a pose to another, each step moves one of the joints 2 to 5,
        and the last one joints 1 and 6; None if no path was found.
    """
    grid = _Grid(solver.chain)
    T = solver.chain.fk(np.random.default_rng(0).uniform(-np.pi, np.pi, (_POSES, 6)))
    solutions = solve(solver, T)
    for q, valid in zip(np.asarray(solutions.q), np.asarray(solutions.valid), strict=True):
        by_region: dict[int, tuple[Array, list[Array]]] = {}
        for x in q[valid]:
            ramp = grid.on_ramp(x)
            if ramp is None:
                continue
            region = grid.region(ramp[-1])
            if region not in by_region:
                by_region[region] = x, ramp
                continue
            other, other_ramp = by_region[region]
            if np.abs(shortest(x - other)).max() < _DISTINCT:
                continue
            # Joints 1 and 6 have no part in the determinant.
            ends = [np.array([other[0], *q[1:5], other[5]]) for q in ramp[::-1]]
            return np.array([*other_ramp, *grid.path(other_ramp[-1], ramp[-1]), *ends, x])
    return None


def keeps_its_sign(chain: Chain, start: Array, joint: int, end: float) -> bool:
    """Whether the Jacobian's determinant keeps its sign while one joint moves the short way from ``start`` to ``end``.

    Args:
        chain: six turning joints.
        start: (6,) rad.
        joint: index of the joint that moves.
        end: its value at the end [rad].
    """
    circle = 2.0 * np.pi * np.arange(5) / 5.0
    Q = np.tile(start, (5, 1))
    Q[:, joint] = start[joint] + circle
    values = _determinants(chain, Q)
    harmonics = np.fft.rfft(values) / 5.0
    step = float(shortest(np.asarray(end - start[joint])))
    along = np.linspace(0.0, step, 17)
    f = harmonics[0].real + 2.0 * np.real(harmonics[1] * np.exp(1j * along) + harmonics[2] * np.exp(2j * along))
    bend = 2.0 * abs(harmonics[1]) + 8.0 * abs(harmonics[2])
    between = bend * (along[1] - along[0]) ** 2 / 8.0
    margin = between + _CLEAR * float(np.abs(harmonics).max()) + _LEAST
    return bool((f > margin).all() or (f < -margin).all())


class _Grid:
    """The Jacobian's determinant on a grid over the joints 2 to 5, and which neighbours are joined without a zero."""

    def __init__(self, chain: Chain) -> None:
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import connected_components

        self._chain = chain
        self._axis = _SPACING * np.arange(_NODES) + 0.1  # off the symmetric places, where determinants like to vanish
        Q = np.zeros((*_SHAPE, 6))
        Q[..., 1:5] = np.stack(np.meshgrid(*[self._axis] * 4, indexing="ij"), axis=-1)
        values = _determinants(chain, Q)
        nodes = np.arange(values.size).reshape(_SHAPE)
        # The certified moves: from a node to the next one along an axis.
        joined = [_joined(values, k) for k in range(4)]
        here = np.concatenate([nodes[each] for each in joined])
        there = np.concatenate([np.roll(nodes, -1, k)[each] for k, each in enumerate(joined)])
        self._graph = csr_array((np.ones(len(here), np.int8), (here, there)), (values.size, values.size))
        self._regions = connected_components(self._graph, directed=False)[1]

    def region(self, q: Array) -> int:
        """Number of the region of a joint vector on the grid: moves along the grid lead from one to all of it."""
        return int(self._regions[self._node(q)])

    def on_ramp(self, q: Array) -> list[Array] | None:
        """Certified moves from ``q`` (6,) to a node near it, joint by joint; None where one is not certified."""
        ramp, goal = [q], self._vector(self._node(q), q)
        for joint in _MOVING:
            if not keeps_its_sign(self._chain, ramp[-1], joint, goal[joint]):
                return None
            there = ramp[-1].copy()
            there[joint] = goal[joint]
            ramp.append(there)
        return ramp

    def path(self, start: Array, end: Array) -> list[Array]:
        """Shortest certified moves between two joint vectors of one region of the grid, both left out."""
        from scipy.sparse.csgraph import breadth_first_order

        first, last = self._node(start), self._node(end)
        before = breadth_first_order(self._graph, first, directed=False)[1]
        nodes = [last]
        while nodes[-1] != first:
            nodes.append(int(before[nodes[-1]]))
        return [self._vector(node, start) for node in nodes[-2:0:-1]]

    def _node(self, q: Array) -> int:
        places = np.round((q[1:5] - self._axis[0]) / _SPACING).astype(np.intp) % _NODES
        return int(np.ravel_multi_index(tuple(places), _SHAPE))

    def _vector(self, node: int, like: Array) -> Array:
        """The node's joint vector, with joints 1 and 6 of another one."""
        return np.array([like[0], *self._axis[list(np.unravel_index(node, _SHAPE))], like[5]])


def _joined(values: Array, axis: int) -> NDArray[np.bool_]:
    """Whether the polynomial through the values of each line along an axis has no zero up to the next node."""
    harmonics = np.fft.rfft(np.moveaxis(values, axis, -1)) / _NODES
    size = np.abs(harmonics)
    bend = 2.0 * size[..., 1] + 8.0 * size[..., 2]
    margin = bend * (_SPACING / _FINER) ** 2 / 8.0 + _CLEAR * size.max(axis=-1) + _LEAST
    padded = np.zeros((*harmonics.shape[:-1], _NODES * _FINER // 2 + 1), dtype=complex)
    padded[..., :3] = harmonics[..., :3]
    fine = np.fft.irfft(padded, _NODES * _FINER) * _NODES * _FINER
    fine = fine.reshape(*values.shape, _FINER)
    # Up to the next node, that one included.
    fine = np.concatenate([fine, np.roll(fine[..., :1], -1, axis=-2)], axis=-1)
    clear = (fine > margin[..., None, None]).all(axis=-1) | (fine < -margin[..., None, None]).all(axis=-1)
    return np.moveaxis(clear, -1, axis)


def _determinants(chain: Chain, Q: Array) -> Array:
    """Determinants (...) of the Jacobian at Q (..., 6), lengths as shares of the arm's size."""
    J = np.array(chain.jacobian(Q))
    J[..., :3, :] /= chain.size
    return np.asarray(np.linalg.det(J))
