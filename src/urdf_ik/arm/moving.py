"""How an arm moves: along a path that is known, and after targets as they come."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from urdf_ik.arm.in_cell import InCell

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from urdf_ik import paths
    from urdf_ik.ik.tasks import Targets


class Moving(InCell):
    """An arm that is moved."""

    _targets: Targets | None

    def follow(
        self,
        T: Any,
        *,
        start: ArrayLike | None = None,
        end: ArrayLike | None = None,
        world: Any = None,
        margin: float = 0.0,
        collisions: bool = True,
        cost: str = "l2",
        weights: ArrayLike | None = None,
        margins: float = 0.0,
        max_step: ArrayLike | None = None,
        tolerance: tuple[float, float] | None = None,
        reconfigure: bool = False,
    ) -> paths.Plan:
        """The cheapest joint motion along a path, over all branches and turns, without a jump.

        From waypoint to waypoint the joints move linearly, and the tip is proven to keep within a tolerance of the
        straight segment; where it would not, waypoints are put in between, and ``Plan.motion`` holds them. Of an arm
        with a redundancy parameter, its values are searched on a grid first, and then on finer ones around the way
        found: the cheapest in that neighbourhood. With a free axis (:meth:`Arm.with_free_axis`) the rotation about it
        does not count, and the plan never costs more than the one that keeps it. Of several parameters all but one are
        held at a few values, and moved together then: see :mod:`urdf_ik.paths.planner.several_parameters`.

        Args:
            T: (m, 4, 4) m, waypoints; see :func:`urdf_ik.line`, :func:`urdf_ik.arc`, :func:`urdf_ik.polyline`.
            start: (n,) joint vector at the first waypoint; default: whichever is best.
            end: (n,) joint vector at the last waypoint; default: whichever is best.
            world: the :class:`urdf_ik.World` of obstacles to stay clear of.
            margin: m that bodies must stay apart.
            collisions: whether collisions are checked, at the waypoints and all the way between them: of the arm with
                itself, where the URDF has collision shapes, and with the world.
            cost: what is minimised, summed over the steps: 'l1' the sum of ``|dq|`` of the joints, 'l2' that of dq^2,
                'max' the largest ``|dq|``, 'time' the time of a step at the URDF's velocity limits.
            weights: (n,) factors of ``|dq|``, of dq^2 for 'l2'; default: 1, which adds rad and m.
            margins: weight of a further cost at each waypoint: the square of how near the joints come to their limits,
                0 in the middle of a joint's range and 1 at its limit, of the joint that comes nearest.
            max_step: rad or m that a joint may move between two waypoints: a number, or (n,).
            tolerance: (m, rad) that the tip may stray from the straight segments; default: (0.001, 0.02), four times as
                much where no plan keeps to that. ``Plan.tolerance`` says which.
            reconfigure: where no joint motion leads all the way, the plan with the fewest changes of branch between
                waypoints.

        Returns:
            See :class:`urdf_ik.Plan`; where ``found`` is false, ``explain()`` says how far each branch gets.

        Raises:
            ArgumentError: waypoints, start, end or a setting that make no sense; the message says what would be valid.
            PoseError: a waypoint is no pose.
            ArgumentError: ``start`` or ``end`` is no joint vector.
            UrdfError: a world is given, and the arm has no collision shapes.
            UnsupportedArm: no solver takes this arm.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> T0 = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
            >>> T1 = T0.copy()
            >>> T1[1, 3] += 0.2
            >>> plan = arm.follow(urdf_ik.line(T0, T1, 50))
            >>> plan.found, len(plan.q), len(set(plan.branches))
            (True, 50, 1)
        """
        from urdf_ik.paths.follow import follow

        arm: Any = self
        return follow(
            arm, T, start=start, end=end, world=world, margin=margin, collisions=collisions, cost=cost,
            weights=weights, margins=margins, max_step=max_step, tolerance=tolerance, reconfigure=reconfigure,
        )  # fmt: skip

    def tracker(self, q0: ArrayLike, dt: float, **options: Any) -> paths.Tracker:
        """A tracker of targets, one each cycle of ``dt`` s, from ``q0`` on: see :class:`urdf_ik.paths.Tracker`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> tracker = arm.tracker([0.3, -0.5, 0.8, 0.4, 0.7, -0.2], dt=0.004)
            >>> tracker.step(arm.fk([0.301, -0.5, 0.8, 0.4, 0.7, -0.2])).status
            'ok'
        """
        from urdf_ik import paths

        arm: Any = self
        return paths.Tracker(arm, q0, dt, targets=self._targets, **options)
