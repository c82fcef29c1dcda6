"""``IKSolutions``, the result of ``arm.ik``: filters, turns, and the choice of a solution."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions import distances, limits, tables
from urdf_ik.ik.solutions.branch_names import turned_branches
from urdf_ik.ik.solutions.derivatives import DifferentiableSolutions
from urdf_ik.ik.solutions.proof import Proof, proof_of
from urdf_ik.ik.solutions.solution import Step
from urdf_ik.kinematics import velocity
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array


class IKSolutions(DifferentiableSolutions):
    """The solutions of one pose or of a batch of poses, one column a branch.

    The solutions of a single pose are iterated over, counted with ``len`` and picked with ``s[k]``, the valid
    ones only; a batch is indexed like a NumPy array of its poses, ``s[i]``, ``s[2:5]``, ``s[mask]``.
    ``within_limits``, ``turns``, ``collision_free``, ``nearest`` and ``best`` return solutions, and compose. Solutions
    do not change.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
        >>> len(s), s.q.shape, s[0].branch
        (8, (8, 6), 'shoulder front, elbow up, wrist flip')
    """

    __slots__ = ()

    def within_limits(self, tol: float = limits.LIMIT_TOLERANCE) -> "IKSolutions":
        """The solutions inside the joint limits.

        The solver returns angles in (-pi, pi]. An angle outside the limits is replaced by its nearest image, whole
        turns away, inside them: -1 becomes 5.28 for a joint from 0 to 6.28. A solution without such an image is
        dropped. A continuous joint is always inside. Images made by ``turns`` are kept or dropped unchanged.

        Args:
            tol: rad or m that a returned value may exceed a limit by; a negative value is a margin to keep.

        Raises:
            ArgumentError: ``tol`` is not finite.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560")
            >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
            >>> len(s), len(s.within_limits())
            (8, 2)
        """
        return self._moved_inside(limits.nearest_image(self._q, self.solver.limits, self._turning, tol), tol)

    def turns(self, tol: float = limits.LIMIT_TOLERANCE) -> "IKSolutions":
        """Every +-2 pi image inside the joint limits: up to 8 x 64 for six joints of +-2 pi.

        The columns of one branch are neighbours, the image with the fewest turns first. A column's name ends with
        its turns, '... [q1+360°]', where all poses share them (a single pose always does), else with the number
        of the image. ``names`` and ``Solution.branch`` always give the turns. A prismatic or continuous joint has
        one image only. Filter collisions first: images do not change them.

        Args:
            tol: rad or m that a returned value may exceed a limit by.

        Raises:
            ArgumentError: ``tol`` is not finite, or there are too many images for one array.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560")
            >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
            >>> len(s), len(s.turns())
            (8, 3)
        """
        if "turns" in self.filters:
            return self
        turned = limits.turns(self._q, self.solver.limits, self.solver.chain.image_turns, tol)
        columns = np.repeat(np.arange(self._q.shape[-2]), len(turned.ranks))
        info = np.where(turned.valid, self._info[..., columns], np.uint8(0))
        before = self._turns_of(self._q)
        apart: Array = self.solver.chain.image_turns
        total = [k * apart[i] + before[..., i, None] for i, k in enumerate(turned.steps)]
        branches = turned_branches(self._branches, total, turned.ranks)
        step = Step("turns", self, np.broadcast_to(columns, info.shape), tol)
        return self._derived(turned.q, info, branches, step)

    def nearest(
        self,
        q_ref: ArrayLike,
        weights: ArrayLike | None = None,
        n: int = 1,
        *,
        metric: distances.Metric = "l2",
        within: ArrayLike | None = None,
        within_limits: bool = False,
        modulo_turns: bool = False,
    ) -> "IKSolutions":
        """The solution nearest to a joint vector, for every pose: one column, or ``n`` of them, nearest first.

        Each joint stands at its image nearest to ``q_ref``, of those inside its limits where there are any, and a
        difference is the full motion of the joint. After ``turns`` the images are those of the columns. Of equally near
        solutions, the first branch counts.

        Args:
            q_ref: (n,) or one for each pose (..., n), rad or m.
            weights: (n,) not negative; default: 1 for every joint.
            n: number of columns, at most B.
            metric: 'l2': ``sqrt(sum of weight * difference^2)``; 'max': the greatest ``weight * |difference|``; 'time':
                the greatest ``weight * |difference| / speed``, seconds at the URDF's velocity limits,
                ``arm.solver.velocity_limits``.
            within: rad or m, one number or one a joint, that no joint may be further away; others are dropped.
            within_limits: whether to drop solutions that have no image inside the joint limits. The result is the
                nearest of all ``turns()``, without listing them.
            modulo_turns: whether differences of angles are taken on the circle, at most pi. Joint values then stay as
                they are, and the motion from ``q_ref`` may be longer by whole turns.

        Raises:
            ArgumentError: ``q_ref``, ``weights`` or ``within`` do not fit the arm, or are not finite.
            ArgumentError: ``n`` is not a number of columns, ``within`` is negative, ``metric`` is unknown, or the
                URDF lacks a speed that 'time' needs.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
            >>> arm.ik(arm.fk(q)).nearest(q)[0].q.round(6).tolist()
            [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
        """
        reference = distances.reference(q_ref, self.solver.joint_names, self.shape)[..., None, :]
        measure = distances.measure(self.solver, metric, weights, within)
        self._require_columns(n, "nearest")
        kept: IKSolutions = self
        if within_limits:
            kept = self._moved_inside(limits.image_near(self._q, reference, self.solver.limits, self._turning))
        q = kept._q if modulo_turns else kept._beside(reference)
        apart = distances.difference(q, reference, self._circles if modulo_turns else np.zeros(len(self.rotary)))
        away = measure.distance(apart)
        if measure.within is not None:
            near = measure.beyond(apart) <= 0.0  # false for NaN rows
            q, info = np.where(near[..., None], q, np.nan), np.where(near, kept._info, np.uint8(0))
            step = Step("within", kept, apart=apart, within=measure.within)
            kept = self._derived(q, info, self._branches, step)
            away = np.where(near, away, np.inf)
        return kept._picked(distances.least_columns(away, n), "nearest", q)

    def difference(self, q_ref: ArrayLike) -> Array:
        """How far each solution is from a joint vector, joint by joint: the full motion to the image nearest to it.

        The image is that of :meth:`nearest`.

        Args:
            q_ref: (n,) or one for each pose (..., n), rad or m.

        Returns:
            (..., B, n) rad or m, NaN where there is no solution.

        Raises:
            ArgumentError: ``q_ref`` does not fit the arm, or is not finite.
        """
        reference = distances.reference(q_ref, self.solver.joint_names, self.shape)[..., None, :]
        return np.asarray(self._beside(reference) - reference)

    def best(self, by: distances.Quality | distances.Wish, n: int = 1, *, world: Any = None) -> "IKSolutions":
        """The solution that is best by a measure of quality, for every pose: one column, or ``n``, best first.

        Of equally good solutions, the first branch counts. Where a redundancy parameter was left at its default, poses
        without a solution inside the joint limits are solved at another value, which ``redundancy`` says.

        Args:
            by: 'limits': farthest from the joint limits. Each solution counts by its image farthest inside them, the
                best of its ``turns()``; a solution without an image inside is dropped. 'manipulability',
                'clearance' and a :class:`urdf_ik.Wish`: see :meth:`scores`. A wish keeps to the joint limits, and
                looks at all values of a redundancy parameter with :meth:`urdf_ik.Arm.intervals` left at its default.
            n: number of columns, at most B.
            world: obstacles for 'clearance', a ``urdf_ik.World``.

        Raises:
            ArgumentError: ``by`` is unknown, ``n`` is not a number of columns, or a world is given to a measure
                other than 'clearance'.
            UrdfError: 'clearance' is asked for, and the URDF's collision shapes are missing or cannot be read.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> arm.ik(arm.fk([0.3, 0.5, 0.1, 0.2])).best("limits")[0].branch
            'elbow right'
        """
        self._require_columns(n, "best")
        distances.check_quality(by, self.solver.chain)
        kept: IKSolutions = self
        if self.solver.parameters and self._redundancy is None and self.step is None:
            has_intervals = len(self.solver.parameters) == 1 and self.solver.redundant_member.self_motion is not None
            if isinstance(by, distances.Wish) and n == 1 and has_intervals:
                wished: IKSolutions = self.arm.intervals(self._poses).best(by)
                return wished
            kept = self.arm.ik(self._poses, redundancy=self.arm.values_inside(self._poses))
        if isinstance(by, distances.Wish):
            kept = kept.within_limits()
        if by == "limits":
            kept = kept._moved_inside(limits.image_inmost(kept._q, self.solver.limits, self._turning))
        scores = kept.scores(by, world=world)
        return kept._picked(distances.least_columns(np.where(np.isnan(scores), np.inf, -scores), n), "best")

    def scores(self, by: distances.Quality | distances.Wish, *, world: Any = None) -> Array:
        """The quality of each solution, (..., B): more is better, NaN where there is no solution.

        Args:
            by: 'limits': how far it is from the joint limits, see :func:`urdf_ik.ik.solutions.limits.margin`.
                'manipulability': Yoshikawa's measure, of the translation for an arm that controls only a position.
                'clearance': m, how far the arm's links are from touching each other or the world. A wish: m, the
                link's height, or its distance from the place, negated.
            world: obstacles for 'clearance', a ``urdf_ik.World``.

        Raises:
            ArgumentError: ``by`` is unknown, or a world is given to a measure other than 'clearance'.
            UrdfError: 'clearance' is asked for, and the URDF's collision shapes are missing or cannot be read.
        """
        distances.check_quality(by, self.solver.chain)
        if world is not None and by != "clearance":
            raise ArgumentError(f"by={quoted(str(by))} looks at no world; leave it out, or take by='clearance'")
        if by == "limits":
            return limits.margin(self._q, self.solver.limits)
        places = np.nonzero(self._info & 1)
        vectors = self._q[places]
        scores = np.full(self._info.shape, np.nan)
        if isinstance(by, distances.Wish):
            scores[places] = by.scores(self.solver.chain, vectors)
        elif by == "manipulability":
            scores[places] = velocity.manipulability(self.solver.chain, vectors, self.solver.control.part)
        elif len(vectors):
            scores[places] = self.arm.cell.in_world(world).distance(vectors)
        return scores

    def collision_free(self, world: Any = None, margin: float = 0.0) -> "IKSolutions":
        """The solutions in which the arm touches neither itself nor an obstacle, by ``arm.cell.collisions``.

        Args:
            world: the :class:`urdf_ik.World` around the arm; default: none, only the arm itself.
            margin: m that the bodies must stay apart.

        Raises:
            ArgumentError: ``margin`` is negative or not finite.
            UrdfError: the URDF has no collision shapes, or not all of them were found.
            ArgumentError: an obstacle's mesh cannot be read, or it has the name of a link.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("zyyzyz_6r"), urdf_ik.World()
            >>> world.add("ball", urdf_ik.Sphere(0.3), urdf_ik.pose([0.4, 0.0, 1.6]))
            >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
            >>> len(s), len(s.collision_free(world))
            (8, 4)
        """
        margin = inputs.number(margin, "margin", low=0.0, unit="m")
        q, info = self._q.copy(), self._info.copy()
        places = np.nonzero(info & 1)
        model = self.arm.cell.in_world(world)
        hits = np.asarray(model.in_collision(q[places], margin), dtype=np.bool_)
        dropped = tuple(place[hits] for place in places)
        q[dropped], info[dropped] = np.nan, 0
        return self._derived(q, info, self._branches, Step("collision", self, amount=margin, model=model))

    def configuration(self, vendor: str) -> NDArray[np.str_]:
        """The configuration of each solution as a maker's controller writes it; '' where there is no solution.

        :mod:`urdf_ik.ik.configurations` has the rules and their sources. The URDF's joint values are taken for those of
        the controller, which the makers' own URDFs have.

        Args:
            vendor: 'abb', 'fanuc', 'kuka', 'staubli' or 'motoman'.

        Returns:
            (..., B) such as '0 -1 0 1' (cf1 cf4 cf6 cfx), 'NUT 0 0 0', 'S 2 T 35'.

        Raises:
            ArgumentError: an unknown vendor.
            UnsupportedArm: the arm is not of the structure that has configurations.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560")
            >>> arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).configuration("fanuc")[0].item()
            'NUT 0 0 0'
        """
        from urdf_ik.ik import configurations

        flat = configurations.codes(self.solver.chain, self._q, vendor)
        found = np.full(flat.shape[:-1], "", dtype="<U64")
        for place in zip(*np.nonzero(self._info & 1), strict=True):
            found[place] = configurations.text(flat[place].tolist(), vendor)
        return found

    def with_configuration(self, written: str, vendor: str) -> "IKSolutions":
        """The solutions with a configuration as a maker's controller writes it, such as 'NUT 0 0 0' of 'fanuc'.

        Where it has turn numbers, every image inside the joint limits counts (:meth:`turns`), and every solution as it
        stands; parts that are left out do not count: 'NUT', 'S 2', 'lefty', '4' (ABB's cfx).

        Raises:
            ArgumentError: an unknown vendor, or text that is no configuration of its.
            UnsupportedArm: the arm is not of the structure that has configurations.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560")
            >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).with_configuration("FUT", "fanuc")
            >>> len(s), s[0].branch
            (1, 'shoulder front, elbow up, wrist flip')
        """
        from urdf_ik.ik import configurations

        wanted = configurations.read(written, vendor)
        kept = self._with_images() if configurations.depends_on_turns(wanted, vendor) else self
        there = configurations.codes(self.solver.chain, kept._q, vendor)
        compared = [k for k, number in enumerate(wanted) if number is not None]
        same = (there[..., compared] == [wanted[k] for k in compared]).all(axis=-1)
        q, info = np.where(same[..., None], kept._q, np.nan), np.where(same, kept._info, np.uint8(0))
        return kept._derived(q, info, kept._branches, Step("configuration", kept, model=(written, vendor)))

    def to_frame(self, *, contacts: bool = True) -> Any:
        """The solutions as a tidy ``pandas.DataFrame``, one row each; frames of several arms can be put together.

        Columns: ``arm``; ``pose``, its number (and ``pose_0``, ``pose_1``, ... where a batch has several axes);
        ``redundancy``, the values that it was solved at; ``branch``; ``q1`` to ``qn`` [rad or m]; ``within_limits``,
        whether that filter keeps it; ``limit_margin`` and ``manipulability``, as the arm's methods give them;
        ``contact``, whether links touch (missing where that was not checked); ``status`` of the pose; ``singular``, as
        words. ``frame.attrs`` holds the names behind them: ``arm``, ``base``, ``tip``, ``joints``, ``units``,
        ``redundancy``, and in ``contacts`` why contacts were not checked.

        Args:
            contacts: whether contacts are checked; some 10 us a solution.

        Raises:
            MissingPackage: pandas is not installed.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560")
            >>> frame = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).to_frame()
            >>> len(frame), int(frame["within_limits"].sum()), frame.attrs["joints"]["q1"]
            (8, 2, 'joint_1')
        """
        return tables.to_frame(self, contacts)

    def _repr_html_(self) -> str:
        return tables.html(self)

    def explain(self) -> str:
        """Why there is no solution: out of reach, with the number that is, or dropped by limits or collisions.

        Returns:
            A sentence for a single pose, '' if it has a solution. For a batch a line for each pose without one, which
            begins with the pose's index.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> print(arm.ik([0.3, 0.0], task="planar position").explain())
            the tip is 0.3 m from axis 1, reach 0.196 m: 0.104 m too far
        """
        if not self.shape:
            return tables.explanation(self)
        lost = [place for place in np.ndindex(self.shape) if not self._info[place].any()]
        return "\n".join(f"pose {list(place)}: {tables.explanation(self[place])}" for place in lost)

    @property
    def proof(self) -> Proof | None:
        """What is proven about a single pose's solutions, as data that others can check; None for solvers without.

        The pose is solved again for it. General arms of six turning joints have it: those that are solved by
        elimination.

        Raises:
            ArgumentError: this is a batch.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560")
            >>> arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).proof is None
            True
        """
        if self.shape:
            raise ArgumentError(f"proof needs a single pose, and these are {self.shape}: take one, s[i].proof")
        data = None if self.solver.core is None else self.solver.core.prove(np.ascontiguousarray(self._poses))
        return None if data is None else proof_of(data)

    def table(self, degrees: bool = False) -> str:
        """The solutions of a single pose as text, a line each; a batch in one sentence.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> print(arm.ik(arm.fk([0.3, 0.5, 0.1, 0.2])).table(degrees=True))
            scara_rrpr: 2 solutions
            #  branch       q1 [deg]  q2 [deg]  q3 [m]  q4 [deg]
            0  elbow left      43.40    -28.65  0.1000    -19.63
            1  elbow right     17.19     28.65  0.1000     11.46
        """
        return tables.table(self, degrees)

    def __str__(self) -> str:
        return self.table()

    def __repr__(self) -> str:
        filters = "".join(f", {name}" for name in self.filters)
        if self.shape:
            return f"<IKSolutions of {self.solver.name}: poses {self.shape}, {self.count.sum()} solutions{filters}>"
        columns = self._info.shape[-1]
        at = tables.parameters_in_words(self)
        return f"<IKSolutions of {self.solver.name}: {self.count} in {columns} columns{at}, {self.status}{filters}>"

    def _require_columns(self, n: int, what: str) -> None:
        inputs.whole(n, f"the n {what} of {self._q.shape[-2]} columns: n", low=1, high=self._q.shape[-2])

    @property
    def _circles(self) -> Array:
        """(n,) turns from one image of a joint to the next, 0 where its images are columns of their own."""
        round_for_ever = np.isinf(self.solver.limits).any(axis=1)
        return np.where(round_for_ever, self.solver.chain.image_turns, self._turning)

    def _beside(self, reference: Array) -> Array:
        """(..., B, n) each joint at its image nearest to references (..., 1, n)."""
        return limits.image_beside(self._q, reference, self.solver.limits, self._circles)

    def _moved_inside(
        self, images: tuple[Array, NDArray[np.bool_]], tol: float = limits.LIMIT_TOLERANCE
    ) -> "IKSolutions":
        """The images inside the joint limits, and which of them there are."""
        q, inside = images
        info = np.where(inside, self._info, np.uint8(0))
        return self._derived(q, info, self._branches, Step("limits", self, amount=tol))

    def _with_images(self) -> "IKSolutions":
        """These, and every image of theirs inside the joint limits."""
        turned, (lower, upper), most = self.turns(), self.solver.limits.T, limits.LIMIT_TOLERANCE
        if turned is self or turned.step is None:
            return self
        outside = ((self._q < lower - most) | (self._q > upper + most)).any(axis=-1)
        q = np.concatenate([turned._q, np.where(outside[..., None], self._q, np.nan)], axis=-2)
        info = np.concatenate([turned._info, np.where(outside, self._info, np.uint8(0))], axis=-1)
        own = np.broadcast_to(np.arange(self._q.shape[-2]), outside.shape)
        columns = np.concatenate([np.asarray(turned.step.columns), own], axis=-1)
        return self._derived(q, info, turned._branches + self._branches, turned.step._replace(columns=columns))

    def _picked(self, columns: NDArray[np.intp], how: str, q: Array | None = None) -> "IKSolutions":
        """The solutions in these columns (..., n); ``q``: (..., B, n) their values, if they are other images."""
        q = np.take_along_axis(self._q if q is None else q, columns[..., None], axis=-2)
        info = np.take_along_axis(self._info, columns, axis=-1)
        names = tuple(how if k == 0 else f"{how} {k + 1}" for k in range(columns.shape[-1]))
        return self._derived(q, info, names, Step(how, self, columns))

    def _derived(self, q: Array, info: NDArray[np.uint8], branches: tuple[str, ...], step: Step) -> "IKSolutions":
        return IKSolutions(self.solver, self._poses, q, info, branches, None, step, self._redundancy)
