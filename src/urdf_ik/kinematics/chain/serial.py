"""A serial chain from a base link to a tip link, as screw axes at the zero configuration."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik import _core
from urdf_ik.errors import ArgumentError, ChainError
from urdf_ik.support import inputs
from urdf_ik.support.read_only import Frozen
from urdf_ik.typing import Array

# Steps between the axes are rounding errors if they are below this share of the distance to the first axis, or below
# this length [m] for each slide: slides travel about a metre, and poses at that distance are rounded to 1e-16 m, which
# is more than the tolerances of so small an arm.
_NO_STEP = 1e-9
_NO_STEP_OF_SLIDES = 1e-5


@dataclass(frozen=True)
class TreeJoint(Frozen):
    """One joint of the URDF's whole tree, as :meth:`Chain.link_poses` walks it.

    ``column`` is the index in the joint vector that drives it (None: it stays at ``offset``), with
    value = multiplier * q[column] + offset; ``driver`` is the joint that it mimics, or the joint itself; '' for a
    joint that does not move. ``rpy`` [rad] and ``axis_length`` are those of the joint's origin and axis as written.
    """

    parent: str
    child: str
    origin: NDArray[np.float64]
    axis: NDArray[np.float64]
    prismatic: bool
    column: int | None
    multiplier: float
    offset: float
    driver: str = ""
    name: str = ""
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis_length: float = 1.0

    @cached_property
    def motion(self) -> Any:  # a _core.Chain, of whose answers the generated stub says nothing
        """The compiled motion from the parent's frame to the child's."""
        R, steps = np.ascontiguousarray(self.origin[:3, :3]), np.zeros((2, 3))
        steps[0] = self.origin[:3, 3]
        return _core.Chain((R @ self.axis)[None], steps, R, np.array([self.prismatic]))

    def held(self, free: list[int], q: NDArray[np.float64], beside: Mapping[str, float]) -> "TreeJoint":
        """This joint when only the columns ``free`` of the joint vector are left, the others held at ``q``.

        Joints beside the chain stand at the values in ``beside``.
        """
        if self.column is None:
            value = beside.get(self.driver)
            return self if value is None else replace(self, offset=self.offset + self.multiplier * value)
        if self.column in free:
            return replace(self, column=free.index(self.column))
        return replace(self, column=None, offset=self.offset + self.multiplier * float(q[self.column]))


class Follower(NamedTuple):
    """A joint of the chain that mimics another: value = multiplier * q[driver] + offset."""

    name: str
    driver: str
    multiplier: float
    offset: float

    def __str__(self) -> str:
        return f"{self.name} = {self.multiplier:g} {self.driver}{f' {self.offset:+g}' if self.offset else ''}"


@dataclass(frozen=True)
class Chain(Frozen):
    """The joints between ``base`` and ``tip`` as a product of exponentials.

    Where joints mimic others, a :class:`urdf_ik.kinematics.chain.mimic.CoupledChain`.

    Attributes:
        base: base link; every pose is expressed in it.
        tip: tip link; its pose is what forward kinematics gives.
        joint_names: movable joints, base to tip.
        joint_types: 'revolute', 'continuous' or 'prismatic', one a joint.
        H: (n, 3) unit directions of the joint axes at q = 0, in base axes.
        P: (n + 1, 3) m, steps from the base origin to axis 1, from axis to axis, from axis n to the tip.
        R_tip: (3, 3) rotation of the tip in the base at q = 0.
        limits: (n, 2) rad or m; a continuous joint has (-inf, inf). What mimics it narrows a joint's limits.
        tree: every joint of the URDF, parents first, in the base link's frame.
        root: the URDF's root link.
        locked: (name, value [rad or m]) of the joints that ``lock`` has made part of the fixed geometry.
        followers: the joints from base to tip that mimic others.

    Example:
        >>> import urdf_ik
        >>> chain = urdf_ik.load("scara_rrpr").chain
        >>> chain.joint_names, chain.H.shape, chain.P.shape
        (('joint_1', 'joint_2', 'joint_3', 'joint_4'), (4, 3), (5, 3))
    """

    base: str
    tip: str
    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    H: NDArray[np.float64]
    P: NDArray[np.float64]
    R_tip: NDArray[np.float64]
    limits: NDArray[np.float64]
    tree: tuple[TreeJoint, ...] = field(repr=False, default=())
    root: str = ""
    locked: tuple[tuple[str, float], ...] = ()
    followers: tuple[Follower, ...] = ()

    def __post_init__(self) -> None:
        for array in (self.H, self.P, self.R_tip, self.limits):
            array.setflags(write=False)

    @property
    def n(self) -> int:
        """Number of movable joints."""
        return len(self.joint_names)

    @cached_property
    def prismatic(self) -> NDArray[np.bool_]:
        """(n,) true for prismatic joints."""
        slides = np.array([kind == "prismatic" for kind in self.joint_types], dtype=np.bool_)
        slides.setflags(write=False)
        return slides

    @property
    def links(self) -> tuple[str, ...]:
        """Links from base to tip."""
        parent = {joint.child: joint.parent for joint in self.tree}

        def up(link: str) -> list[str]:
            links = [link]
            while links[-1] in parent:
                links.append(parent[links[-1]])
            return links

        above, below = up(self.base), up(self.tip)
        shared = next((link for link in above if link in below), None)
        if shared is None:
            return self.base, self.tip
        return *above[: above.index(shared) + 1], *reversed(below[: below.index(shared)])

    @cached_property
    def motion(self) -> Any:  # a _core.Chain, of whose answers the generated stub says nothing
        """The compiled chain."""
        axes = self.axes
        return _core.Chain(axes.H, axes.P, axes.R_tip, axes.prismatic)

    @property
    def axes(self) -> "Chain":
        """The chain of the moving axes: this one, but where joints mimic others."""
        return self

    @property
    def directions(self) -> NDArray[np.float64]:
        """(n, 3) unit direction of each joint's axis at q = 0, of the first axis that it moves."""
        return self.H

    @property
    def image_turns(self) -> NDArray[np.float64]:
        """(n,) turns after which a joint is in the same posture: 1, or 0 for one that slides."""
        return np.where(self.prismatic, 0.0, 1.0)

    @property
    def points(self) -> NDArray[np.float64]:
        """(n, 3) m, a point on each joint axis at q = 0."""
        return np.cumsum(self.P, axis=0)[:-1]

    @cached_property
    def size(self) -> float:
        """Length that tolerances are relative to [m]: the sum of the steps between the axes and to the tip.

        If these are only rounding errors, it is the distance to the first axis, plus 1 m for each slide.
        """
        between, base = float(np.linalg.norm(self.P[1:], axis=1).sum()), float(np.linalg.norm(self.P[0]))
        slides = int(self.prismatic.sum())
        if between > max(_NO_STEP * base, _NO_STEP_OF_SLIDES * slides):
            return between
        return base + slides or 1.0

    def with_screws(self, H: NDArray[np.float64], P: NDArray[np.float64], R_tip: NDArray[np.float64]) -> "Chain":
        """The same joints with other axes, as of a URDF with other numbers."""
        return replace(self, H=H, P=P, R_tip=R_tip)

    def reversed(self) -> "Chain":
        """The same joints from tip to base: its poses are the inverses, its joint vectors run backwards."""
        back = self.R_tip.T
        points = np.vstack([self.P.sum(axis=0), self.points[::-1], np.zeros(3)])
        return replace(
            self,
            base=self.tip,
            tip=self.base,
            joint_names=self.joint_names[::-1],
            joint_types=self.joint_types[::-1],
            H=-self.H[::-1] @ back.T,
            P=np.diff(points, axis=0) @ back.T,
            R_tip=np.ascontiguousarray(back),
            limits=self.limits[::-1].copy(),
        )

    def lock(self, values: Mapping[str, float]) -> "Chain":
        """The chain of the other joints, with these held still: they become part of the fixed geometry.

        Args:
            values: joint name to the value [rad or m] that the joint is held at, inside its limits or not. Joints of
                the URDF beside the chain, of another arm for instance, stand at theirs instead of at zero.

        Raises:
            ChainError: there is no such joint, or it is held already; the error lists those that there are.
            ArgumentError: a value is no finite number.

        Example:
            >>> import urdf_ik
            >>> urdf_ik.load("scara_rrpr").chain.lock({"joint_3": 0.1}).joint_names
            ('joint_1', 'joint_2', 'joint_4')
        """
        if not (held := _held_values(self, values)):
            return self
        beside = {name: value for name, value in held.items() if name not in self.joint_names}
        q = np.array([held.get(name, 0.0) for name in self.joint_names])
        free = [k for k, name in enumerate(self.joint_names) if name not in held]
        return replace(
            self if len(free) == self.n else self.at_rest(q, free),
            tree=tuple(joint.held(free, q, beside) for joint in self.tree),
            locked=(*self.locked, *held.items()),
            followers=tuple(each for each in self.followers if each.driver not in held),
        )

    def at_rest(self, q: NDArray[np.float64], free: Sequence[int]) -> "Chain":
        """The chain of the joints ``free``, with its zero where all joints have the values ``q`` (n,)."""
        axes, points, home = self.placed(q)
        return replace(
            self,
            joint_names=tuple(self.joint_names[k] for k in free),
            joint_types=tuple(self.joint_types[k] for k in free),
            H=axes[free],
            P=np.diff(np.vstack([np.zeros(3), points[free], home[:3, 3]]), axis=0),
            R_tip=home[:3, :3].copy(),
            limits=self.limits[free],
        )

    def fk(self, q: ArrayLike) -> NDArray[np.float64]:
        """Pose of the tip in the base.

        Args:
            q: (..., n) rad or m; a row of NaN, as solutions are padded with, gives NaN.

        Returns:
            (..., 4, 4) homogeneous transforms.

        Raises:
            ArgumentError: the last dimension is not n, or another value is not finite.

        Example:
            >>> import urdf_ik
            >>> chain = urdf_ik.load("scara_rrpr").chain
            >>> (chain.fk([0.0, 0.0, 0.1, 0.0])[:3, 3].round(6) + 0.0).tolist()
            [0.6, 0.0, 0.23]
        """
        T: NDArray[np.float64] | None = self.motion.fk(q)
        return over_gaps(self.check(q, padded=True), self.motion.fk) if T is None else T

    def jacobian(self, q: ArrayLike) -> NDArray[np.float64]:
        """Geometric Jacobian at the tip, in base axes, linear rows above angular ones.

        Args:
            q: (..., n) rad or m; a row of NaN gives NaN.

        Returns:
            (..., 6, n).

        Raises:
            ArgumentError: the last dimension is not n, or another value is not finite.

        Example:
            >>> import urdf_ik
            >>> chain = urdf_ik.load("planar_2r").chain
            >>> (chain.jacobian([0.0, 0.0]).round(6) + 0.0)[[0, 1, 5]].tolist()
            [[0.0, 0.0], [0.196, 0.13], [1.0, 1.0]]
        """
        J: NDArray[np.float64] | None = self.motion.jacobian(q)
        return over_gaps(self.check(q, padded=True), self.motion.jacobian) if J is None else J

    def placed(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Directions (n, 3) of the axes at a joint vector (n,), points (n, 3) on them, the tip's pose (4, 4)."""
        q = self.check(q)
        # Such a place becomes geometry: its numbers must be the same on every processor.
        placed: Any = _core.prepared(lambda: (self.motion.axes(q), self.motion.fk(q)))
        axes, tip = placed
        return axes[3:].T.copy(), axes[:3].T.copy(), tip

    def link_poses(self, q: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Pose of every link of the URDF in the base link's frame.

        Joints outside the chain stay at zero; one that mimics a joint of the chain follows it.

        Args:
            q: (..., n) rad or m; a row of NaN gives NaN.

        Returns:
            Link name to (..., 4, 4).

        Raises:
            ArgumentError: the last dimension is not n, or another value is not finite.
        """
        Q, gone = filled(self.check(q, padded=True))
        batch = Q.shape[:-1]
        free = {self.root: np.broadcast_to(np.eye(4), (*batch, 4, 4))}
        for joint in self.tree:
            drive = np.full(batch, joint.offset)
            if joint.column is not None:
                drive += joint.multiplier * Q[..., joint.column]
            free[joint.child] = free[joint.parent] @ joint.motion.fk(drive[..., None])
        to_base = np.linalg.inv(free[self.base])
        to_base[gone] = np.nan
        return {link: to_base @ pose for link, pose in free.items()}

    def check(self, q: ArrayLike, *, padded: bool = False) -> NDArray[np.float64]:
        """``q`` as a C-contiguous float64 array (..., n); ``padded``: rows that are all NaN are let through.

        Raises:
            ArgumentError: the last dimension is not n, or a value is not finite.
        """
        Q = inputs.real(q, "a joint vector", f"an array of numbers (..., {self.n})")
        if Q.ndim == 0 or Q.shape[-1] != self.n:
            raise ArgumentError(
                f"joint vectors of shape {Q.shape} given; the chain has {self.n} joints "
                f"({', '.join(self.joint_names)}), so the last dimension must be {self.n}"
            )
        where = inputs.first_bad(Q)
        if where is not None and padded:
            where = inputs.first_bad(np.where(np.isnan(Q).all(axis=-1, keepdims=True), 0.0, Q))
        if where is not None:
            raise ArgumentError(
                f"joint vector{list(where[:-1]) or ''}: joint {self.joint_names[where[-1]]!r} "
                f"is {Q[where]}; {inputs.why_bad(Q[where])}"
            )
        return Q


def _held_values(chain: Chain, values: Mapping[str, float]) -> dict[str, float]:
    """Names and values of joints to hold, as :meth:`Chain.lock` takes and refuses them."""
    if not isinstance(values, Mapping):
        raise ArgumentError(f"locked={values!r} given; names of joints with values are needed, such as {{name: 0.0}}")
    held = {
        name: inputs.number(value, f"joint {name!r} cannot be locked: its value", unit="rad or m")
        for name, value in values.items()
    }
    there = dict.fromkeys([*chain.joint_names, *(joint.driver for joint in chain.tree if joint.column is None)])
    able = [name for name in there if name and name not in dict(chain.locked)]
    if unknown := [name for name in held if name not in able]:
        where = "it is locked already" if unknown[0] in dict(chain.locked) else "no joint of that name moves by itself"
        raise ChainError(
            f"joint {unknown[0]!r} cannot be locked: {where}; the chain is that from {chain.base!r} to {chain.tip!r}",
            able,
        )
    return held


def filled(q: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Joint vectors (..., n) with zeros in the rows that are NaN, and which rows (...) these are."""
    gone = np.asarray(np.isnan(q).any(axis=-1))
    return (np.where(gone[..., None], 0.0, q) if gone.any() else q), gone


def over_gaps(q: Array, compute: Callable[[Array], Array]) -> Array:
    """``compute`` of joint vectors (..., n), an array (..., ...) of floats, with NaN where a row is NaN."""
    whole, gone = filled(q)
    if whole is q:
        return compute(q)
    out = np.array(compute(whole), dtype=np.float64)
    out[gone] = np.nan
    return out
