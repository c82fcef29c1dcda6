"""Coal's check of one pair of shapes: whether they touch, and how far they are apart.

Pinocchio places the arm's shapes. An obstacle is placed when a pair with it is checked.
"""

import heapq
import threading
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from urdf_ik.cell.coal_shapes import Solid
from urdf_ik.cell.distance_bounds import QUERY_ERROR, Bodies, DistanceBounds, Placed
from urdf_ik.cell.obstacles import Obstacle, Obstacles
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.kinematics.chain import Chain
from urdf_ik.typing import Array

Indices = NDArray[np.intp]
Pair = tuple[str, str]


class ShapePair(NamedTuple):
    """Two shapes of links that must not touch: the links' names, and the shapes' places among the arm's."""

    names: Pair
    first: int
    second: int


class ArmShapes:
    """The collision shapes of a URDF; all worlds share them.

    Attributes:
        reference: Pinocchio's model.
        geometry: Pinocchio's geometry model, which places the shapes.
        links: link of each shape.
        offsets: from the link to its shape.
        solids: the shapes with their hulls.
        bodies: how the shapes move with the joint vector.
        ball_centres: (S, 3) m of the single balls that hold the shapes, each in its link's frame.
    """

    def __init__(self, reference: Reference, chain: Chain, geometry: Any, solids: Sequence[Solid]) -> None:
        self.reference, self.geometry, self.solids = reference, geometry, solids
        frames, objects = reference.pin_model.frames, geometry.geometryObjects
        self.links = [frames[body.parentFrame].name for body in objects]
        # Pinocchio's placement of a shape is relative to the movable joint that carries the link.
        self.offsets = [frames[body.parentFrame].placement.actInv(body.placement) for body in objects]
        balls = {id(solid): (solid.one_ball(), solid.covering_balls()) for solid in solids}
        single, several = zip(*(balls[id(solid)] for solid in solids), strict=True)
        self.ball_centres = np.array(
            [offset.act(centre) for offset, (centre, _) in zip(self.offsets, single, strict=True)]
        )
        covering = [[offset.act(c) for c in balls] for offset, (balls, _) in zip(self.offsets, several, strict=True)]
        self.bodies = Bodies(
            chain,
            self.links,
            (self.ball_centres, np.array([radius for _, radius in single])),
            (np.array(covering), np.array([radii for _, radii in several])),
        )
        self.work = _Work(reference.pin_model, geometry)
        base = frames[reference.base_frame]
        self._base = base.parentJoint, pin.SE3(base.placement)

    def place(self, q: Array) -> "_Placing":
        """Every shape where Pinocchio puts it at ``q`` (n,), in memory of the thread: until it places them again."""
        work, (joint, base) = self.work, self._base
        configuration = self.reference.configuration(q)
        pin.updateGeometryPlacements(self.reference.pin_model, work.data, self.geometry, work.geometry, configuration)
        return _Placing(work.geometry.oMg, lambda: work.data.oMi[joint] * base, {})

    def place_at(self, link_poses: Mapping[str, Array]) -> "_Placing":
        """:meth:`place` with every link at a given pose (4, 4); with obstacles, the base link's pose is needed too."""
        se3 = {link: pin.SE3(pose[:3, :3], pose[:3, 3]) for link, pose in link_poses.items()}
        shapes = [se3[link] * offset for link, offset in zip(self.links, self.offsets, strict=True)]
        return _Placing(shapes, lambda: se3[self.reference.base], {})


class _Placing(NamedTuple):
    """Where everything is.

    Attributes:
        shapes: poses of the arm's shapes, each a ``pinocchio.SE3``, which coal's queries take.
        find_base: gives ``base``, which obstacles alone need.
        obstacles: poses of obstacles by their names, where they were needed.
    """

    shapes: Any
    find_base: Callable[[], Any]
    obstacles: dict[str, Any]

    @property
    def base(self) -> Any:
        """The base link's pose, a ``pinocchio.SE3``."""
        return self.find_base()

    def obstacle(self, obstacle: Obstacle) -> Any:
        """The pose of an obstacle, a ``pinocchio.SE3``."""
        if obstacle.name not in self.obstacles:
            self.obstacles[obstacle.name] = self.base * pin.SE3(obstacle.pose)
        return self.obstacles[obstacle.name]


class _Work(threading.local):
    """Scratch memory, one a thread."""

    def __init__(self, model: Any, geometry: Any) -> None:
        self.data = model.createData()
        self.geometry = geometry.createData()
        self.request, self.result = coal.CollisionRequest(), coal.CollisionResult()


class CoalCheck:
    """Pairs of an arm's shapes and of a world's obstacles that must not touch, by their numbers in ``bounds``.

    It is immutable; any number of threads may use it.

    Attributes:
        arm: the arm's shapes.
        pairs: the pairs of links.
        obstacles: those of the world.
        bounds: lower bounds on distances; they number the pairs.
    """

    def __init__(
        self,
        arm: ArmShapes,
        pairs: Sequence[ShapePair],
        obstacles: Obstacles | None = None,
        excepted: Collection[tuple[int, str]] = (),
        added: Collection[tuple[int, str]] = (),
    ) -> None:
        """Combine the arm's pairs with the obstacles.

        Args:
            arm: the arm's shapes.
            pairs: of shapes of two links.
            obstacles: those of the world. Every shape that the joint vector moves is checked against all of them.
            excepted: pairs of a shape that moves and an obstacle that are not checked.
            added: pairs of a shape that does not move and an obstacle that are checked.
        """
        self.arm, self.pairs = arm, tuple(pairs)
        self.obstacles = Obstacles(()) if obstacles is None else obstacles
        excepted_pairs, added_pairs = (
            [(shape, number) for shape, name in some if (number := self.obstacles.number(name)) is not None]
            for some in (excepted, added)
        )
        among_links = [(pair.first, pair.second) for pair in pairs]
        self.bounds = DistanceBounds(arm.bodies, among_links, self.obstacles, excepted_pairs, added_pairs)

    def _with_obstacle(self, pair: int) -> tuple[int, int]:
        """The shape and the obstacle of a pair."""
        return divmod(pair - len(self.pairs), len(self.obstacles))

    def names(self, pair: int) -> Pair:
        """Names of the two links of a pair, or of its link and its obstacle."""
        if pair < len(self.pairs):
            return self.pairs[pair].names
        shape, obstacle = self._with_obstacle(pair)
        return self.arm.links[shape], self.obstacles.standing[obstacle].name

    def touches(self, placing: _Placing, pair: int, margin: float = 0.0, *, hulls: bool = False) -> bool:
        """Whether a pair comes within a margin [m], its convex hulls first; ``hulls``: whether these do."""
        one, other, grown, at, there = self._placed(placing, pair)
        request, result = self.arm.work.request, self.arm.work.result
        request.security_margin = margin + grown
        if one.hull is not None or other.hull is not None:
            result.clear()
            if not coal.collide(one.hull or one.exact, at, other.hull or other.exact, there, request, result):
                return False
            if hulls:
                return True
        result.clear()
        return bool(coal.collide(one.exact, at, other.exact, there, request, result))

    def distance(self, placing: _Placing, pair: int, hulls: bool = False) -> float:
        """Distance of a pair [m], or of its hulls, which is a lower bound; zero or less in collision."""
        one, other, grown, at, there = self._placed(placing, pair)
        first, second = (hulls and one.hull) or one.exact, (hulls and other.hull) or other.exact
        result = coal.DistanceResult()
        coal.distance(first, at, second, there, coal.DistanceRequest(), result)
        return float(result.min_distance) - grown

    def _placed(self, placing: _Placing, pair: int) -> tuple[Solid, Solid, float, Any, Any]:
        """The two shapes of a pair, the second one's inflation [m], and the poses of both."""
        solids = self.arm.solids
        if pair < len(self.pairs):
            _, first, second = self.pairs[pair]
            return solids[first], solids[second], 0.0, placing.shapes[first], placing.shapes[second]
        shape, obstacle = self._with_obstacle(pair)
        standing, other = self.obstacles.standing[obstacle], self.obstacles.bounds[obstacle].solid
        return solids[shape], other, standing.shape.inflation, placing.shapes[shape], placing.obstacle(standing)

    def nearest(
        self, placing: _Placing, pairs: Sequence[int], least: Sequence[float], known: dict[tuple[int, bool], float]
    ) -> tuple[int | None, float]:
        """The nearest of some pairs and its distance [m], zero in collision.

        Args:
            placing: the placed shapes.
            pairs: numbers of pairs.
            least: lower bounds on their distances [m].
            known: known distances at this placing, by pair and whether they are those of its hulls; new ones are
                added.
        """
        best, nearest = np.inf, None

        def distance(pair: int, hulls: bool) -> float:
            if (pair, hulls) not in known:
                known[pair, hulls] = self.distance(placing, pair, hulls)
            return known[pair, hulls]

        # Lower bound, whether the hulls gave it, pair.
        waiting = [(bound, False, pair) for pair, bound in zip(pairs, least, strict=True)]
        heapq.heapify(waiting)
        while waiting and best > 0.0:
            bound, of_hulls, pair = heapq.heappop(waiting)
            if bound >= best:
                break
            if not of_hulls and any(each.hull is not None for each in self._placed(placing, pair)[:2]):
                heapq.heappush(waiting, (max(bound, distance(pair, True) - QUERY_ERROR), True, pair))
            elif (distance_of_pair := max(distance(pair, False), 0.0)) < best:
                best, nearest = distance_of_pair, pair
        return nearest, best

    def nearest_of_each(self, q: Array) -> Iterator[tuple[int | None, float]]:
        """:meth:`nearest` of all pairs, for each of the joint vectors (k, n)."""
        bounds = self.bounds
        for part, placed in bounds.chunks(q):
            links = bounds.links_closest(placed)
            known: list[dict[tuple[int, bool], float]] = [{} for _ in links]
            # The distance to a few likely obstacles bounds the search for the nearest one.
            guess = self._each(q[part], placed, links, *bounds.likely(placed.centres), known)
            limit = np.array([distance for _, distance in guess]) + QUERY_ERROR
            row, pair = bounds.near(placed.centres, np.repeat(limit[:, None], placed.centres.shape[1], axis=1))
            yield from self._each(q[part], placed, links, row, pair, known)

    def _each(
        self,
        q: Array,
        placed: Placed,
        links: Array,
        row: Indices,
        pair: Indices,
        known: Sequence[dict[tuple[int, bool], float]],
    ) -> Iterator[tuple[int | None, float]]:
        """:meth:`nearest` of the links, whose bounds are (k, A), and of some pairs with obstacles, for q (k, n)."""
        order = np.argsort(row, kind="stable")
        row, pair = row[order], pair[order]
        least = self.bounds.gaps(placed, row, pair).min(axis=1)
        ends = np.searchsorted(row, np.arange(len(q) + 1)).tolist()
        for i, among_links in enumerate(links):
            own = slice(ends[i], ends[i + 1])
            pairs = [*range(len(among_links)), *pair[own].tolist()]
            limits = [*among_links.tolist(), *least[own].tolist()]
            yield self.nearest(self.arm.place(q[i]), pairs, limits, known[i])

    def every_pair(self) -> list[int]:
        """The numbers of all pairs."""
        shapes = len(self.arm.links)
        _, with_obstacles = self.bounds.near(np.zeros((1, shapes, 3)), np.full((1, shapes), np.inf))
        return [*range(len(self.pairs)), *with_obstacles.tolist()]
