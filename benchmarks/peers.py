"""Other solvers on an arm of this package, to be timed and judged; none of them is a dependency.

Each is built from the arm's URDF or its screw axes, and called in the shortest way that its own documentation gives.
"""

import importlib
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import urdf_ik
from urdf_ik.kinematics.dh import DHTable


class Unavailable(Exception):  # noqa: N818 - it is an answer, not a failure
    """The peer is not installed or does not take the arm; the message goes into the table."""


def _same(poses: np.ndarray) -> Any:
    return poses


@dataclass(frozen=True)
class Peer:
    """A solver on one arm.

    Attributes:
        kind: its key in ``PEERS``.
        name: what a table calls it.
        solve: all solutions (k, n) of one prepared pose; rows of NaN are no solutions. Timed.
        prepare: a pose (4, 4), or many (m, 4, 4), in the form that the solver's calls take. Not timed.
        batch: all solutions of many prepared poses with a number of threads; None where the solver has no such call.
        flagged: all solutions (k, n) of one prepared pose, and which (k,) the solver itself calls approximate.
    """

    kind: str
    name: str
    solve: Callable[[Any], Any]
    prepare: Callable[[np.ndarray], Any] = _same
    batch: Callable[[Any, int], Any] | None = None
    flagged: Callable[[Any], tuple[np.ndarray, np.ndarray]] | None = None

    def claims(self, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """All solutions (k, n) of a pose, and which (k,) of them the solver says only come near."""
        if self.flagged is not None:
            return self.flagged(self.prepare(pose))
        found = np.asarray(self.solve(self.prepare(pose)), dtype=float)
        found = found.reshape(-1, found.shape[-1] if found.size else 6)
        return found, np.zeros(len(found), dtype=bool)


def this(arm: urdf_ik.Arm) -> Peer:
    """This package."""
    return Peer("urdf-ik", "urdf-ik", lambda T: arm.ik(T).q, batch=lambda T, threads: arm.ik(T, threads=threads).q)


def eaik(arm: urdf_ik.Arm) -> Peer:
    """EAIK (Ostermeier, Kuelz and Althoff 2025), from the screw axes."""
    binding, wrapper = _package("eaik.pybindings.EAIK"), _package("eaik.IK_Robot")
    chain = _six(arm)
    robot = wrapper.IKRobot()
    robot._robot = binding.Robot(np.array(chain.H).T, np.array(chain.P).T, np.array(chain.R_tip), [], True)
    if not robot.hasKnownDecomposition():  # asked first: without one, it raises or ends the process
        raise Unavailable("no decomposition for this arm")

    def flagged(T: Any) -> tuple[np.ndarray, np.ndarray]:
        answer = robot.IK(T)
        return np.array(answer.Q).reshape(-1, 6), np.array(answer.is_LS, dtype=bool)

    return Peer(
        "EAIK", f"EAIK {version('eaik')}", lambda T: np.array(robot.IK(T).Q), batch=robot.IK_batched, flagged=flagged
    )


def ik_geo(arm: urdf_ik.Arm) -> Peer:
    """ik-geo (Elias and Wen 2022, in Ostermeier's Rust port), from the screw axes."""
    package, chain = _package("ik_geo"), _six(arm)
    axes, points, home = np.array(chain.H), np.cumsum(chain.P, axis=0), np.array(chain.R_tip)
    family, kind = arm.structure.family or "", "gen_six_dof"
    # It wants the points of axes that meet where they meet.
    if "spherical wrist" in family and "2||3" in family:
        kind = "spherical_two_parallel"
        points[3:6] = next(np.array(each.point) for each in arm.structure.triples if each.first == 4)
    elif "2||3||4" in family and "5x6" in family:
        kind = "three_parallel_two_intersecting"
        along = np.linalg.lstsq(np.stack([axes[4], -axes[5]], axis=1), points[5] - points[4], rcond=None)[0]
        points[4:6] = points[4] + along[0] * axes[4]
    robot = getattr(package.Robot, kind)(axes, np.diff(np.vstack([np.zeros(3), points]), axis=0))

    def prepare(T: np.ndarray) -> Any:
        # Version 1.0.3 reads a rotation that is an array by columns; its poses carry no home rotation.
        return np.ascontiguousarray((T[:3, :3] @ home.T).T), np.ascontiguousarray(T[:3, 3])

    def flagged(prepared: Any) -> tuple[np.ndarray, np.ndarray]:
        answer = robot.get_ik(*prepared)
        return np.array([q for q, _ in answer]).reshape(-1, 6), np.array([flag for _, flag in answer], dtype=bool)

    def solve(prepared: Any) -> np.ndarray:
        return np.array([q for q, _ in robot.get_ik(*prepared)])

    return Peer("ik-geo", f"ik-geo {version('ik-geo')}", solve, prepare, flagged=flagged)


# Parameters a1, a2, b, c1, c2, c3, c4 [m] and offsets [rad] of ortho-parallel arms, by Brandstoetter et al. (2014).
ORTHO_PARALLEL = {
    "zyyzyz": ((0.0, 0.0, 0.0, 1.0, 1.0, 1.1, 0.2), (0.0,) * 6),
    "irb2400": ((0.1, -0.135, 0.0, 0.615, 0.705, 0.755, 0.085), (0.0, 0.0, -np.pi / 2, 0.0, 0.0, 0.0)),
}
ORTHO_PARALLEL["zyyzyz_6r"] = ORTHO_PARALLEL["zyyzyz"]


def opw(arm: urdf_ik.Arm) -> Peer:
    """py-opw-kinematics (Brandstoetter, Angerer and Hofbaur 2014), for ortho-parallel arms with a spherical wrist."""
    if arm.name not in ORTHO_PARALLEL:
        raise Unavailable("no ortho-parallel arm")
    package, (lengths, offsets) = _package("py_opw_kinematics"), ORTHO_PARALLEL[arm.name]
    robot = package.Robot(package.KinematicModel(*lengths, offsets=offsets), degrees=False)
    return Peer(
        "py-opw", f"py-opw {version('py-opw-kinematics')}", lambda T: np.array(robot.inverse(T)),
        package.RigidTransform.from_matrix, lambda T, threads: robot.reach(T, threads=threads).joints,
    )  # fmt: skip


def ssik(arm: urdf_ik.Arm) -> Peer:
    """Ssik's general entry point, from the URDF, without its joint limits; what it derives is derived here."""
    robot = ssik_robot(arm)

    def solve(T: np.ndarray) -> np.ndarray:
        return np.array([s.q for s in robot.solve(T, respect_limits=False)])

    solve(arm.fk(np.full(arm.dof, 0.3)))
    return Peer("ssik", f"ssik {version('ssik')}", solve)


def ssik_robot(arm: urdf_ik.Arm) -> Any:
    """Its model of an arm."""
    package = _package("ssik")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "arm.urdf")
        path.write_bytes(arm.model.xml)
        try:
            return package.Manipulator.from_urdf(path, base=arm.base, ee=arm.tip)
        except Exception as error:  # whatever it refuses an arm with
            raise Unavailable(f"it refuses the arm: {error}") from None


def frankik(arm: urdf_ik.Arm) -> Peer:
    """Frankik (He and Liu 2021), for Franka's Panda, at 60 values of joint 7, inside the joint limits."""
    package = _package("frankik")
    forward = np.linalg.inv(arm.fk(np.zeros(7))) @ package.fk(np.zeros(7))
    # Its inverse takes the flange: 45 degrees and 103.4 mm before the frame of its forward kinematics.
    flange = forward @ urdf_ik.pose([0.0, 0.0, -0.1034], rpy=[0.0, 0.0, np.pi / 4])
    return Peer(
        "frankik", f"frankik {version('frankik')}",
        lambda T: np.array(package.ik_sample_q7(T @ flange, None, False, 60, 332.0, True)),
    )  # fmt: skip


def crx(arm: urdf_ik.Arm) -> Peer:
    """crx-kinematics, for the CRX-10iA/L: mm and degrees, poses in the shoulder, joint 3 measured from joint 2."""
    if arm.name != "fanuc_crx10ial":
        raise Unavailable("no CRX")
    robot = _package("crx_kinematics").Crx.crx10ial()
    scale = np.array([[1.0, 1.0, 1.0, 1e3]] * 3 + [[1.0] * 4])
    in_shoulder = np.linalg.inv(urdf_ik.pose([0.0, 0.0, 0.245]))

    def solve(T: np.ndarray) -> np.ndarray:
        q = np.radians(robot.ik(T))
        q[:, 2] += q[:, 1]
        return q

    name = f"crx-kinematics {version('crx-kinematics')}"
    return Peer("crx-kinematics", name, solve, lambda T: (in_shoulder @ T) * scale)


def toolbox(arm: urdf_ik.Arm) -> Peer:
    """The Robotics Toolbox's analytic solver in Python, from a table of standard Denavit-Hartenberg parameters."""
    package, poses = _package("roboticstoolbox"), _package("spatialmath")
    table = DHTable.from_chain(_six(arm), "standard", snap=1e-9)
    # Closed forms need right angles to be right.
    quarters = [np.round(angles / (np.pi / 2)) * (np.pi / 2) for angles in (table.alpha, table.theta)]
    alpha, theta = (
        np.where(np.abs(angles - near) < 1e-9, near, angles)
        for angles, near in zip((table.alpha, table.theta), quarters, strict=True)
    )
    links = [package.RevoluteDH(d=table.d[k], a=table.a[k], alpha=alpha[k], offset=theta[k]) for k in range(6)]
    base, tool = (poses.SE3(frame, check=False) for frame in (table.base, table.tool))
    robot = package.DHRobot(links, name=arm.name, base=base, tool=tool)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that python-flint would be faster
            solver = robot.analytic_ik()
    except Exception as error:  # whatever it refuses an arm with
        raise Unavailable(f"it derives no solver: {error}") from None
    name = f"Robotics Toolbox {version('roboticstoolbox-python')}"
    return Peer("toolbox", name, lambda T: solver.solve(T, joint_limits=False).q)


def _package(name: str) -> Any:
    """A package that need not be installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise Unavailable("not installed") from None


def _six(arm: urdf_ik.Arm) -> Any:
    """The chain of an arm with six turning joints."""
    if arm.dof != 6 or not arm.structure.is_6r:
        raise Unavailable("it takes six turning joints")
    return arm.chain


PEERS: dict[str, Callable[[urdf_ik.Arm], Peer]] = {
    "urdf-ik": this, "EAIK": eaik, "ik-geo": ik_geo, "py-opw": opw, "ssik": ssik, "toolbox": toolbox,
    "crx-kinematics": crx,
}  # fmt: skip
