"""Tasks that an arm with few joints controls, and the targets of a planar arm.

These are x, y in the arm's plane ('planar position'), or x, y and an angle ('planar pose'); other tasks are a
:class:`urdf_ik.Task`.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError, PoseError, UnsupportedArm
from urdf_ik.ik.families import FamilyMember, few_joints, planar
from urdf_ik.kinematics.chain import Chain, least_stretches, sampled
from urdf_ik.kinematics.chain.plane import Plane, plane_of
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

_WIDTH = {"planar position": 2, "planar pose": 3}
TASKS = ("pose", "position", "position and axis", *_WIDTH)
# Smallest singular value of a task's Jacobian, at the middle one of sampled joint vectors, that counts as control.
CONTROL = 1e-3


@dataclass(frozen=True, eq=False)
class Control:
    """The part of the tip's pose that an arm controls.

    Attributes:
        task: one of ``TASKS``.
        plane: the plane of a planar arm, else None.
        aimed: for 'position and axis', the axis (3,) in the tip's frame whose direction is controlled, else None.
    """

    task: str
    plane: Plane | None = None
    aimed: Array | None = None

    @property
    def part(self) -> str:
        """Rows of the Jacobian that matter: 'translation' where only a position is controlled, else 'all'."""
        return "translation" if self.task in ("position", "planar position") else "all"

    def target_of(self, T: Array) -> Array:
        """The target of this task that belongs to poses ``T`` (..., 4, 4) of the tip [m]."""
        if self.task == "pose":
            return T
        if self.task == "position":
            return np.ascontiguousarray(T[..., :3, 3])
        if self.aimed is not None:
            return np.concatenate([T[..., :3, 3], T[..., :3, :3] @ self.aimed], axis=-1)
        assert self.plane is not None
        return np.ascontiguousarray(self.plane.coordinates(T)[..., : _WIDTH[self.task]])

    def errors(self, T: Array, targets: Array) -> tuple[Array, Array]:
        """How far poses ``T`` (..., 4, 4) of the tip are from targets (..., k) in the plane.

        Returns:
            Distances (...) [m] and angles (...) [rad], which are 0 where the task has no angle.
        """
        off = self.target_of(T) - targets
        return np.linalg.norm(off[..., :2], axis=-1), np.abs(shortest(off[..., 2:])).sum(axis=-1)


def control_of(chain: Chain) -> Control:
    """The part of the tip's pose that a chain controls; see ``Arm.task``."""
    if chain.axes is not chain:
        return Control("pose")
    plane = plane_of(chain)
    if chain.n > 5 or chain.n < 2:
        return Control("pose", plane)
    J = chain.jacobian(sampled(chain))

    def controls(rows: Array) -> bool:
        return float(np.median(least_stretches(chain, rows))) > CONTROL

    if plane is not None:
        linear, turn = plane.axes @ J[:, :3], plane.normal @ J[:, 3:]
        nothing = np.zeros_like(linear[:, :1])
        if chain.n == 2 and controls(np.concatenate([linear, nothing], axis=1)):
            return Control("planar position", plane)
        if chain.n == 3 and controls(np.concatenate([linear, nothing, turn[:, None]], axis=1)):
            return Control("planar pose", plane)
    elif chain.n == 3 and controls(J[:, :3]):
        return Control("position")
    elif chain.n == 5 and not chain.prismatic.any():
        for aimed in np.eye(3)[[2, 0, 1]]:
            if controls_aim(chain, aimed):
                return Control("position and axis", None, aimed)
    return Control("pose", plane)


def controls_aim(chain: Chain, axis: Array) -> bool:
    """Whether five joints control the tip's position and the direction of its ``axis``."""
    q = sampled(chain)
    J, along = chain.jacobian(q), chain.fk(q)[:, :3, :3] @ axis
    across = J[:, 3:] - along[:, :, None] * np.einsum("ki,kij->kj", along, J[:, 3:])[:, None, :]
    return float(np.median(least_stretches(chain, np.concatenate([J[:, :3], across], axis=1)))) > CONTROL


class Targets:
    """The targets of a planar task: their check, and the poses that the solver gets for them.

    Attributes:
        task: 'planar position' or 'planar pose'.
    """

    def __init__(self, name: str, chain: Chain, control: Control, task: str) -> None:
        """Take a task of an arm.

        Args:
            name: the robot's name.
            chain: its joints.
            control: the part of the tip's pose that they control.
            task: the kind of targets.

        Raises:
            ArgumentError: the task is unknown, or the arm cannot control it.
        """
        if task not in TASKS:
            raise ArgumentError(f"no task is called {quoted(task)}; tasks: {', '.join(map(repr, TASKS))}")
        if task != control.task or task == "pose":
            fitting = "the whole pose" if control.task == "pose" else f"the whole pose, or the task {control.task!r}"
            joints = f"{name}: its {chain.n} joints"
            raise ArgumentError(f"{joints} do not control {task!r} and nothing else; give {fitting}")
        assert control.plane is not None  # as the task is planar
        self.task = task
        self._name, self._chain, self._plane = name, chain, control.plane
        self._takes_points = False

    def plan(self, structure: Structure) -> FamilyMember:
        """How the task is solved.

        Raises:
            UnsupportedArm: no solver takes this arm.
        """
        plan = self._planned()
        if plan is None:
            raise UnsupportedArm(f"{self._name}: no solver for the task {quoted(self.task)} of this arm. {structure}")
        self._takes_points = plan.solver.numbers == _WIDTH["planar position"]
        return replace(plan, imperfection=(0.0, 0.0))

    def for_solver(self, targets: Array) -> Array:
        """Targets (m, k) as the compiled solver takes them: as they are, or as poses (m, 4, 4)."""
        return targets if self._takes_points else self.poses(targets)

    def read(self, T: Any) -> Array:
        """A target, or a stack of them, as (..., k) float64 that nobody else writes to."""
        width = _WIDTH[self.task]
        words = f"x, y [m]{' and angle [rad]' * (width == 3)} in the arm's plane, see Arm.solver.control.plane"
        needed = f"an array of numbers, {words}"
        target = inputs.real(T, f"a target for the task {quoted(self.task)}", needed, PoseError)
        if target.ndim == 0 or target.shape[-1] != width:
            raise PoseError(
                f"a target of shape {target.shape} given; the task {quoted(self.task)} takes (..., {width}): {words}"
            )
        if (bad := inputs.first_bad(target)) is not None:
            what = f"the target {target[bad[:-1]].tolist()} for the task {self.task!r}"
            raise PoseError(f"{what} is not finite: {inputs.why_bad(target[bad])}", bad[:-1] or None)
        return target.copy() if target is T else target

    def poses(self, target: Array) -> Array:
        """The target (m, k) as poses (m, 4, 4), of which the solver uses only the parts that the task fixes."""
        plane = self._plane
        T = np.tile(np.eye(4), (len(target), 1, 1))
        # Number by number, not as a product of matrices: its digits depend on how many there are.
        T[:, :3, 3] = plane.origin + target[:, :1] * plane.axes[0] + target[:, 1:2] * plane.axes[1]
        if self.task == "planar pose":
            home = np.eye(4)
            home[:3, :3] = self._chain.R_tip
            T[:, :3, :3] = _turned(home[:3, :3], plane.normal, target[:, 2] - plane.coordinates(home)[2])
        return T

    def _planned(self) -> FamilyMember | None:
        chain, plane = self._chain, self._plane
        if self.task == "planar pose":
            # In an arm that is planar exactly, the whole pose follows from the one in the plane.
            exact = planar.FAMILY.plan(analyse(chain), chain)
            return exact or few_joints.prepare_planar(chain, plane.normal, plane.heading)
        plan = few_joints.prepare_planar(chain, plane.normal, None)
        return None if plan is None else planar.for_points(chain, plan)


def _turned(R: Array, axis: Array, angles: Array) -> Array:
    """The rotation ``R`` (3, 3), turned by angles (m,) about unit ``axis`` (3,): (m, 3, 3)."""
    along = np.outer(axis, axis) @ R
    across = np.cross(axis, R, axisa=0, axisb=0, axisc=0)
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return along + c * (R - along) + s * across
