"""CollisionModel: the collision shapes of an arm and of a world, and the pairs that must not touch."""

import warnings
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.cell import allowed_collisions, coal_shapes, swept_motions
from urdf_ik.cell.allowed_collisions import Table
from urdf_ik.cell.coal_check import ArmShapes, CoalCheck, ShapePair
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.cell.swept_motions import Motions
from urdf_ik.cell.world import World
from urdf_ik.errors import ArgumentError, PoseError, UrdfError
from urdf_ik.kinematics.chain import Chain, from_urdf
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST
from urdf_ik.typing import Array

Pair = tuple[str, str]

SAMPLES = 200
"""Number of random joint vectors by which pairs that always collide are found."""

ALWAYS = 0.95
"""A pair that collides in at least this share of the sampled joint vectors counts as always colliding."""

SEED = 0
"""Seed of these joint vectors: the same URDF gives the same pairs."""


FAR_LARGER = 10.0
"""A mesh whose radius is this many times the size of the arm is likely to be in mm; only a warning depends on it."""


class Nearest(NamedTuple):
    """Two links, or a link and an obstacle, and the distance between them [m]; 0 where they collide.

    Example:
        >>> import urdf_ik
        >>> links, distance = urdf_ik.load("planar_2r").cell.nearest_pair([0.0, 0.0])
        >>> links, distance > 0.0
        (('base_link', 'link_2'), True)
    """

    links: tuple[str, str]
    distance: float


class CollisionModel:
    """The collision shapes of a URDF and of a world, and the pairs that must not touch.

    Joints outside the chain stay at zero; a joint that mimics another follows it. Meshes are surfaces: a mesh wholly
    inside another one does not touch it. The answer for a joint vector does not depend on earlier queries.
    A model is immutable: :meth:`in_world`, :meth:`allow` and :meth:`check` return new ones, which share the shapes.
    The world may change; each query uses its present state. Any number of threads may use one model.

    Attributes:
        joint_names: joints of a joint vector, base to tip.
        world: the world, or None.
        shapes: the collision shapes of the arm.
        reference: Pinocchio's model of the arm.
    """

    def __init__(
        self,
        model: UrdfModel,
        base: str | None = None,
        tip: str | None = None,
        *,
        disabled: Collection[Pair] = (),
        locked: Mapping[str, float] | None = None,
        allowed: Mapping[Pair, str] | None = None,
    ) -> None:
        """Read the collision shapes and decide which pairs to check.

        Args:
            model: the URDF as it was read; meshes come from its ``package_dirs`` only.
            base: base link; default: the root.
            tip: tip link; default: the end of the only movable chain.
            disabled: pairs of an SRDF.
            locked: fixed values of joints outside the joint vector [rad or m].
            allowed: pairs that may touch, to the reason; default: those of the URDF and the SRDF, and those that touch
                in nearly all of ``SAMPLES`` joint vectors.

        Raises:
            ChainError: base or tip is unknown, or the tip is ambiguous.
            UnsupportedArm: the chain has a joint with more than one degree of freedom.
        """
        self._made_from = (model, base, tip, dict(locked or {}))
        self.reference = Reference(model, base, tip, locked=locked)
        self.joint_names = self.reference.joint_names
        self.world: World | None = None
        self._rank = {link: i for i, link in enumerate(model.links)}
        self._changes: dict[Pair, bool] = {}
        self._error: UrdfError | None = None
        self._current: tuple[int, CoalCheck] | None = None
        self._kept: list[ShapePair] | None = None
        # The last result of ``in_world``, as most callers use one world again and again.
        self._last: CollisionModel | None = None
        try:
            geometry, solids = coal_shapes.build(model, self.reference.pin_model)
        except UrdfError as error:
            self._error = error
            return
        chain = from_urdf(model, base, tip).lock(locked or {})
        self.shapes = ArmShapes(self.reference, chain, geometry, solids)
        _ask_about_millimetres(self.shapes, chain)
        excused = {allowed_collisions.ordered(*pair, self._rank) for pair in disabled}
        self._allowed, self._pairs = allowed_collisions.among_links(self.shapes, self._rank, excused)
        if allowed is not None:
            self._allowed = dict(allowed)
        else:
            kept = [pair for pair in self._pairs if pair.names not in self._allowed]
            always = allowed_collisions.always_colliding(CoalCheck(self.shapes, kept), ALWAYS, SAMPLES, SEED)
            self._allowed.update(dict.fromkeys(always, allowed_collisions.ALWAYS_COLLIDE))

    def __reduce__(self) -> tuple[Callable[..., "CollisionModel"], tuple[Any, ...]]:
        return _restored, (self._made_from, self.__dict__.get("_allowed"), self._changes, self.world)

    def __repr__(self) -> str:
        known = "without shapes" if self._error else f"{len(self.checked_pairs)} pairs checked"
        return f"<CollisionModel of {', '.join(self.joint_names)}: {known}>"

    @property
    def has_geometry(self) -> bool:
        """Whether the collision shapes were read; if not, every check raises, and ``missing`` says why."""
        return self._error is None

    @property
    def missing(self) -> str:
        """The reason why ``has_geometry`` is false, else ''."""
        return "" if self._error is None else str(self._error)

    @property
    def unchecked(self) -> str:
        """The same in a few words, such as '6 meshes missing'."""
        return "" if self._error is None else coal_shapes.why_unreadable(self._made_from[0])

    @property
    def checked_pairs(self) -> tuple[Pair, ...]:
        """Pairs that must not touch, two links or a link and an obstacle."""
        return () if self._error else self.table().checked

    def table(self) -> Table:
        """The allowed-collision table, to be read and printed; :meth:`allow` and :meth:`check` change it.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
        """
        self._require_geometry()
        names = [each.name for each in self.present_check().obstacles.standing]
        allowed, pairs = allowed_collisions.with_obstacles(self.shapes, names)
        pairs += [pair.names for pair in self._pairs]
        return allowed_collisions.made({**self._allowed, **allowed}, pairs, self._changes, self._ranks(names))

    def in_world(self, world: World | None) -> "CollisionModel":
        """This model among the obstacles of a world, which may be changed later; itself where ``world`` is None.

        Every link that the joint vector moves against the base link is checked against every obstacle. The other links
        stand on the world, and may touch it ('rigid').
        """
        if world is None or world is self.world:
            return self
        last = self._last
        if last is None or last.world is not world:
            if self._error is None:
                self._checked()  # found once for all worlds
            last = self._copy()
            last.world = world
            self._last = last
        return last

    def allow(self, first: str, second: str) -> "CollisionModel":
        """This model with one more pair that may touch.

        Args:
            first: a link, or an obstacle of the world.
            second: another one.

        Raises:
            ArgumentError: there is no such link or obstacle, or it has no shape.
            UrdfError: there are no collision shapes, or not all of them were found.
        """
        return self._changed(first, second, False)

    def check(self, first: str, second: str) -> "CollisionModel":
        """This model with a pair that must not touch, whatever allowed it to.

        Args:
            first: a link, or an obstacle of the world.
            second: another one.

        Raises:
            ArgumentError: there is no such link or obstacle, or it has no shape.
            UrdfError: there are no collision shapes, or not all of them were found.
        """
        return self._changed(first, second, True)

    @property
    def is_changed(self) -> bool:
        """Whether anything but the URDF decides what is checked: an SRDF, :meth:`allow` or :meth:`check`, a world."""
        is_special = self._changes or self.world or allowed_collisions.SRDF in self._allowed.values()
        return self._error is None and bool(is_special)

    def rebuilt(
        self, model: UrdfModel, base: str | None, tip: str | None, locked: Mapping[str, float] | None
    ) -> "CollisionModel":
        """The model of a URDF that has this one's links and more, with this one's SRDF, changes and world."""
        out = type(self)(model, base, tip, locked=locked)
        if out._error is None:
            out._allowed.update({pair: why for pair, why in self._allowed.items() if why == allowed_collisions.SRDF})
        out._changes, out.world = dict(self._changes), self.world
        return out

    def _copy(self) -> "CollisionModel":
        out = object.__new__(type(self))
        out.__dict__.update(self.__dict__)
        out._current = out._last = None
        return out

    def _changed(self, first: str, second: str, must_not: bool) -> "CollisionModel":
        self._require_geometry()
        obstacles = () if self.world is None else self.world.names
        rank = self._ranks(obstacles)
        pair = allowed_collisions.named(first, second, rank, [*dict.fromkeys(self.shapes.links), *obstacles])
        if pair[0] in obstacles:
            both = f"{quoted(first)} and {quoted(second)}"
            raise ArgumentError(f"{both} are both obstacles, which stand still; a pair has a link")
        out = self._copy()
        out._changes, out._kept = {**self._changes, pair: must_not}, None
        return out

    def _ranks(self, obstacles: Iterable[str]) -> dict[str, int]:
        """Every link and then every obstacle, to its place."""
        return {name: i for i, name in enumerate((*self._rank, *obstacles))}

    def present_check(self) -> CoalCheck:
        """The check of all pairs for the world's present state."""
        world = self.world
        if self._current is None or (world is not None and self._current[0] != world.version):
            version, obstacles = (0, None) if world is None else world.snapshot()
            if same := next((link for link in self._rank if obstacles and obstacles.number(link) is not None), None):
                raise ArgumentError(f"the obstacle {quoted(same)} has the name of a link of the arm; give it another")
            excepted, added = allowed_collisions.exceptions(self.shapes, self._changes, self._rank)
            self._current = version, CoalCheck(self.shapes, self._checked(), obstacles, excepted, added)
        return self._current[1]

    def _checked(self) -> list[ShapePair]:
        """The pairs of links that must not touch, which no world changes."""
        if self._kept is None:
            names = {pair.names for pair in self._pairs}
            checked = set(allowed_collisions.made(self._allowed, names, self._changes, self._rank).checked)
            self._kept = [pair for pair in self._pairs if pair.names in checked]
        return self._kept

    def in_collision(self, q: ArrayLike, margin: float = 0.0) -> bool | NDArray[np.bool_]:
        """Whether a checked pair touches.

        Args:
            q: (..., n) rad or m.
            margin: least distance allowed [m].

        Returns:
            A bool for one joint vector, else (...) bool.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: the last dimension is not n, or a value is not finite.
            ArgumentError: ``margin`` is negative or not finite.
        """
        margin = inputs.number(margin, "margin", low=0.0, unit="m")
        Q, places, check = self._rows(q)
        if not places.all():
            row = np.argwhere(~places)[0].tolist()
            raise ArgumentError(
                f"joint vector{row or ''} is not finite, or beyond {LARGEST:g}; what touches at it cannot be known"
            )
        out = np.zeros(len(Q), dtype=np.bool_)
        for row, touching in self._touching(check, Q, margin):
            out[row] = next(touching, None) is not None
        whole = np.zeros(places.shape, dtype=np.bool_)
        whole[places] = out
        return bool(whole) if whole.ndim == 0 else whole

    def distance(self, q: ArrayLike) -> float | Array:
        """Smallest distance of a checked pair.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.

        Returns:
            A float for one joint vector, else (...) [m]: 0 in collision, infinite if no pair is checked.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: the last dimension is not n.
        """
        Q, places, check = self._rows(q)
        out = np.array([distance for _, distance in check.nearest_of_each(Q)])
        whole = np.full(places.shape, np.nan)
        whole[places] = out
        return float(whole) if whole.ndim == 0 else whole

    def colliding_pairs(self, q: ArrayLike) -> tuple[Pair, ...]:
        """The checked pairs that touch.

        Args:
            q: (n,) rad or m.

        Returns:
            Pairs of names, in the order of ``checked_pairs``.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: q is no (n,), or a value is not finite.
        """
        Q, check = self._one(q)
        (_, touching) = next(self._touching(check, Q, 0.0), (0, iter(())))
        names = {check.names(pair) for pair in touching}
        rank = self._ranks(each.name for each in check.obstacles.standing)
        return tuple(sorted(names, key=lambda pair: (rank[pair[0]], rank[pair[1]])))

    def nearest_pair(self, q: ArrayLike) -> Nearest | None:
        """The checked pair with the smallest distance.

        Args:
            q: (n,) rad or m.

        Returns:
            The pair and its distance; one of them if several collide. None if no pair is checked.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: q is no (n,), or a value is not finite.
        """
        Q, check = self._one(q)
        for pair, distance in check.nearest_of_each(Q):
            if pair is not None:
                return Nearest(check.names(pair), distance)
        return None

    def motions_free(self, q0: ArrayLike, q1: ArrayLike, margin: float = 0.0) -> Motions:
        """Which straight motions in joint space are free from end to end, proven; see :func:`swept_motions.motions`.

        Args:
            q0: (k, n) rad or m, where the motions begin.
            q1: (k, n) rad or m, where they end; every joint moves linearly from one value to the other, full turns
                included.
            margin: least distance allowed [m].

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: the arrays do not fit the arm or each other, are not finite or beyond 1e15, or a joint
                goes farther than ``swept_motions.LONGEST``.
            ArgumentError: ``margin`` is negative or not finite.
        """
        margin = inputs.number(margin, "margin", low=0.0, unit="m")
        self._require_geometry()
        n = len(self.joint_names)
        start, end = (inputs.array(q, name, (None, n)) for name, q in (("q0", q0), ("q1", q1)))
        if start.shape != end.shape:
            raise ArgumentError(f"motions from {start.shape} to {end.shape} given; both must be (k, {n})")
        if (bad := inputs.first_bad(end - start, swept_motions.LONGEST)) is not None:
            motion, joint = bad
            raise ArgumentError(
                f"motion {motion}: joint {self.joint_names[joint]} goes from {start[bad]:g} to {end[bad]:g}; a motion "
                f"of at most {swept_motions.LONGEST:g} rad or m is needed, a longer one in several"
            )
        return swept_motions.motions(self.present_check(), start, end, margin)

    def distance_with(self, link_poses: Mapping[str, ArrayLike]) -> float:
        """:meth:`distance` with the links at given poses instead of Pinocchio's, pair by pair, without bounds.

        Args:
            link_poses: link name to (4, 4) [m], all in one frame.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            PoseError: a link that has a shape has no pose, or a pose is not finite.
        """
        self._require_geometry()
        check = self.present_check()
        needed = dict.fromkeys([*self.shapes.links, *([self.reference.base] if check.obstacles else [])])
        if absent := sorted(set(needed) - set(link_poses)):
            raise PoseError(f"links with collision shapes have no pose: {', '.join(absent)}")
        poses = {link: np.asarray(link_poses[link], dtype=np.float64) for link in needed}
        if bad := next((link for link, T in poses.items() if inputs.first_bad(T) is not None), None):
            raise PoseError(f"the pose of link {quoted(bad)} is not finite: {poses[bad].tolist()}")
        pairs = check.every_pair()
        return check.nearest(self.shapes.place_at(poses), pairs, [-np.inf] * len(pairs), {})[1]

    def _require_geometry(self) -> None:
        if self._error is not None:
            raise self._error.with_traceback(None)

    def _rows(self, q: ArrayLike) -> tuple[Array, NDArray[np.bool_], CoalCheck]:
        """The finite joint vectors (k, n), a mask (...) of their places in ``q``, and the check."""
        self._require_geometry()
        Q = self.reference.vectors(q)
        places = np.asarray((np.abs(Q) <= LARGEST).all(axis=-1))
        rows = np.ascontiguousarray(Q[places]).reshape(int(places.sum()), Q.shape[-1])  # there may be no joints
        return rows, places, self.present_check()

    def _one(self, q: ArrayLike) -> tuple[Array, CoalCheck]:
        """A joint vector as (1, n), and the check."""
        self._require_geometry()
        return inputs.array(q, "one joint vector", (len(self.joint_names),))[None], self.present_check()

    def _touching(self, check: CoalCheck, Q: Array, margin: float) -> Iterator[tuple[int, Iterator[int]]]:
        """Rows of Q (k, n) in which a pair may touch, each with the pairs that do."""
        for part, placed in check.bounds.chunks(Q):
            for i, pairs in check.bounds.near_in_rows(placed, margin):
                placing = check.arm.place(Q[part.start + i])
                yield part.start + i, (pair for pair in pairs if check.touches(placing, pair, margin))


def _ask_about_millimetres(shapes: ArmShapes, chain: Chain) -> None:
    """Warn of meshes that are far larger than the arm."""
    limit = FAR_LARGER * chain.size
    large = [i for i, solid in enumerate(shapes.solids) if solid.is_mesh and solid.one_ball()[1] > limit]
    if large:
        i = max(large, key=lambda i: shapes.solids[i].one_ball()[1])
        width, link = 2.0 * shapes.solids[i].one_ball()[1], shapes.links[i]
        warnings.warn(
            f"{link}: a mesh is {width:.3g} m wide and the arm {chain.size:.3g} m long; is it in mm? "
            'Meshes are read in m: scale="0.001 0.001 0.001"',
            UserWarning,
            stacklevel=2,
        )


def _restored(made_from: Any, allowed: Mapping[Pair, str] | None, changes: Any, world: Any) -> CollisionModel:
    """A collision model as it was before it was pickled: coal's shapes are made again."""
    model, base, tip, locked = made_from
    out = CollisionModel(model, base, tip, locked=locked, allowed=allowed)
    out._changes, out.world = changes, world
    return out
