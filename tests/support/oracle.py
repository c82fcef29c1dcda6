"""The reference of the tests: Pinocchio's own model of the same URDF, and a slow and obvious solver on top of it."""

import math
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]


def angle_distance(a: Array, b: Array) -> Array:
    """Largest difference (...) [rad] between the joint vectors a (..., n) and b (..., n), modulo 2 pi."""
    return np.abs((a - b + np.pi) % (2.0 * np.pi) - np.pi).max(axis=-1)


class Oracle:
    """A serial chain of revolute and continuous joints as Pinocchio reads it.

    Joint vectors hold the joints that move the tip against the base, from base to tip.
    """

    def __init__(self, urdf: str | Path, base: str = "base", tip: str = "tool") -> None:
        """Read URDF text, or a file where a Path is given."""
        text = urdf.read_text() if isinstance(urdf, Path) else urdf
        self.model = pin.buildModelFromXML(text)
        self.data = self.model.createData()
        self.base, self.tip = self._body(base), self._body(tip)
        supports = [set(self.model.supports[self.model.frames[i].parentJoint]) for i in (self.base, self.tip)]
        self.joints = [i for i in sorted(supports[1] - supports[0]) if i > 0]
        self.names = tuple(self.model.names[i] for i in self.joints)
        self.columns = [self.model.joints[i].idx_v for i in self.joints]
        self.dof = len(self.joints)
        self._neutral = pin.neutral(self.model)
        entries = [(self.model.joints[i].idx_q, self.model.joints[i].nq == 2) for i in self.joints]
        # Where in Pinocchio's configuration each joint's value stands, or its cosine with its sine behind.
        self._places = np.array([place for place, _ in entries], dtype=int)
        self._round = np.array([two for _, two in entries], dtype=bool)

    def _body(self, name: str) -> int:
        """Index of a link's frame; Pinocchio itself answers an unknown name with a number."""
        index = self.model.getFrameId(name, pin.FrameType.BODY)
        if index >= self.model.nframes:
            raise KeyError(name)
        return int(index)

    def _full(self, q: Array) -> Array:
        """Pinocchio's configuration, where a continuous joint is a cosine and a sine."""
        full = self._neutral.copy()
        if self._round.any():
            full[self._places + self._round] = np.sin(q)
            full[self._places] = np.where(self._round, np.cos(q), q)
        else:
            full[self._places] = q
        return full

    def pose(self, q: Array) -> Array:
        """Pose (4, 4) of the tip in the base."""
        pin.framesForwardKinematics(self.model, self.data, self._full(q))
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip]).homogeneous

    def poses(self, q: Array) -> Array:
        """Poses (m, 4, 4) of joint vectors (m, n)."""
        return np.array([self.pose(x) for x in q]).reshape(-1, 4, 4)

    def jacobian(self, q: Array) -> Array:
        """Jacobian (6, n), rows linear then angular, at the tip, in the base's axes."""
        return self._placed(q)[1]

    def _placed(self, q: Array) -> tuple[Array, Array]:
        """Pose (4, 4) of the tip in the base, and the Jacobian (6, n)."""
        pin.computeJointJacobians(self.model, self.data, self._full(q))
        pin.updateFramePlacements(self.model, self.data)
        world = pin.getFrameJacobian(self.model, self.data, self.tip, pin.LOCAL_WORLD_ALIGNED)
        # Of a single joint Pinocchio gives a vector.
        world = world.reshape(6, -1)[:, self.columns]
        base = self.data.oMf[self.base]
        turned = [base.rotation.T @ rows for rows in (world[:3], world[3:])]
        return base.actInv(self.data.oMf[self.tip]).homogeneous, np.concatenate(turned)

    def sigma_min(self, q: Array) -> float:
        """Smallest singular value of the Jacobian."""
        return float(np.linalg.svd(self.jacobian(q), compute_uv=False)[-1])

    def error(self, q: Array, target: Array) -> float:
        """The larger of position error [m] and rotation error [rad] of a joint vector (n,) against a pose (4, 4)."""
        pose = self.pose(q)
        turn = pose[:3, :3].T @ target[:3, :3]
        sine = 0.5 * math.hypot(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
        angle = math.atan2(sine, 0.5 * (np.trace(turn) - 1.0))
        return max(math.dist(pose[:3, 3], target[:3, 3]), angle)

    def tolerance(self, q: Array) -> float:
        """How far [rad] a solver's answer may lie from the planted q: rounding in the pose over the conditioning."""
        return 1e-6 + 1e-11 / max(self.sigma_min(q), 1e-14)

    def draw(self, rng: np.random.Generator, m: int) -> Array:
        """Draw joint vectors (m, n) over the whole torus."""
        return rng.uniform(-np.pi, np.pi, (m, self.dof))

    def curvature(self, q: Array) -> float:
        """How fast [1/rad^2] the pose leaves the directions that the Jacobian spans, along its null direction.

        Zero in the middle of a continuum of solutions; where two solutions meet, they are sqrt(8 e / curvature) apart
        in a pose that is e inside the edge.
        """
        left, _, right = np.linalg.svd(self.jacobian(q))
        centre, step = self.pose(q), 1e-4

        def bend(sign: float) -> float:
            pose = self.pose(q + sign * step * right[-1])
            twist = np.concatenate([pose[:3, 3] - centre[:3, 3], pin.log3(pose[:3, :3] @ centre[:3, :3].T)])
            return float(left[:, -1] @ twist)

        return abs(bend(1.0) + bend(-1.0)) / step**2

    def singular_tolerance(self, q: Array) -> float:
        """How far [rad] an answer may lie from a q on a singularity: rounding of the pose moves a fold's solutions."""
        return 1e-6 + 4.0 * math.sqrt(1e-15 / max(self.curvature(q), 1e-8))

    def singular(
        self, rng: np.random.Generator, joint: int | None = None, *, at: Array | None = None, attempts: int = 200
    ) -> tuple[Array, int]:
        """A joint vector (n,) at which the Jacobian's determinant changes sign along one joint, and that joint.

        By bisection, so that no formula of any family enters. ``joint`` fixes the joint that crosses, ``at`` the others
        as long as one of them will do.
        """
        for attempt in range(attempts):
            q = at.copy() if at is not None and attempt < 6 else self.draw(rng, 1)[0]
            j = int(rng.integers(self.dof)) if joint is None else joint

            def determinant(value: float, q: Array = q, j: int = j) -> float:
                moved = q.copy()
                moved[j] = value
                return float(np.linalg.det(self.jacobian(moved)))

            grid = np.linspace(-np.pi, np.pi, 25)
            values = np.array([determinant(value) for value in grid])
            crossings = np.flatnonzero(values[:-1] * values[1:] < 0.0)
            if not len(crossings):
                continue
            i = int(rng.choice(crossings))
            low, high, at_low = grid[i], grid[i + 1], values[i]
            while (middle := 0.5 * (low + high)) not in (low, high):
                at_middle = determinant(middle)
                if at_low * at_middle > 0.0:
                    low, at_low = middle, at_middle
                else:
                    high = middle
            q[j] = middle
            return q, j
        raise AssertionError(f"no singularity found along joint {joint}")

    def solutions(self, target: Array, rng: np.random.Generator, starts: int = 120) -> Array:
        """All solutions (k, n) that Newton finds from so many random starts; slow, and complete on regular poses."""
        found: list[Array] = []
        for q in self.draw(rng, starts):
            solution = self.newton(q, target)
            if solution is not None and all(angle_distance(solution, other) > 1e-5 for other in found):
                found.append((solution + np.pi) % (2.0 * np.pi) - np.pi)
        return np.array(found).reshape(-1, self.dof)

    def newton(self, q: Array, target: Array) -> Array | None:
        """Damped Newton from one start, or None where it does not arrive."""
        for _ in range(40):
            pose, jacobian = self._placed(q)
            turn = target[:3, :3] @ pose[:3, :3].T
            error = np.concatenate([target[:3, 3] - pose[:3, 3], pin.log3(turn)])
            size = float(error @ error)
            if size < 1e-24:
                return q
            damping = (1e-3 * min(size, 1.0) + 1e-14) * np.eye(self.dof)
            step = np.linalg.solve(jacobian.T @ jacobian + damping, jacobian.T @ error)
            q = q + step * min(1.0, 1.0 / max(float(np.abs(step).max()), 1e-9))
        return None
