"""The solvers that the benchmark compares, behind one small interface.

Each takes a 4x4 pose and answers with a (k, 6) array of joint vectors [rad], as it stands after the shortest way that
its own documentation gives. Whatever a peer wants prepared (a pose object, another frame) is prepared off the clock.
"""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import adapters
import numpy as np
from robots import Robot

import urdf_ik


class Unavailable(Exception):  # noqa: N818 - it is an answer, not a failure
    """The peer is not installed or does not take the arm; the message goes into the table."""


class Peer(ABC):
    """One solver on one arm.

    Attributes:
        name: what the table calls it.
        single_call: the call that is timed for one pose.
        batch_call: the call that is timed for many, or None where the solver has none.
    """

    name: str
    single_call: str
    batch_call: str | None = None

    @abstractmethod
    def __init__(self, robot: Robot) -> None:
        """Prepare the solver for the arm, or raise Unavailable."""

    def prepare(self, target: np.ndarray) -> Any:
        """The pose (4, 4) in the form that the solver's call takes; not timed."""
        return target

    def prepare_batch(self, targets: np.ndarray) -> Any:
        """The poses (n, 4, 4) in the form that the solver's batch call takes; not timed."""
        return targets

    @abstractmethod
    def solve(self, prepared: Any) -> np.ndarray:
        """All solutions (k, 6) of one prepared pose; rows of NaN are no solutions. Timed."""

    def claims(self, prepared: Any) -> tuple[np.ndarray, np.ndarray]:
        """All solutions (k, 6), and which (k,) of them the solver says only come near. Not timed."""
        found = self.solve(prepared).reshape(-1, 6)
        return found, np.zeros(len(found), dtype=bool)

    def solve_batch(self, prepared: Any, threads: int) -> Any:
        """All solutions of the prepared poses with so many threads. Timed."""
        raise NotImplementedError


class UrdfIk(Peer):
    """This package."""

    name = "urdf-ik"
    single_call = "arm.ik(T).q"
    batch_call = "arm.ik(T, threads=...).q"

    def __init__(self, robot: Robot) -> None:
        """Load the arm from its URDF text."""
        self.arm = urdf_ik.load(robot.urdf, base="base", tip="tool")

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        found: np.ndarray = self.arm.ik(prepared).q
        return found

    def solve_batch(self, prepared: Any, threads: int) -> Any:
        """Many poses."""
        return self.arm.ik(prepared, threads=threads).q


class Eaik(Peer):
    """EAIK (Ostermeier, Kuelz, Althoff 2025), given the axes that Pinocchio reads from the same URDF."""

    name = "EAIK"
    single_call = "np.array(bot.IK(T).Q)"
    batch_call = "bot.IK_batched(T, threads)"

    def __init__(self, robot: Robot) -> None:
        """Build it from H, P and the home rotation."""
        try:
            import eaik.pybindings.EAIK as binding
            from eaik.IK_Robot import IKRobot
        except ImportError as error:
            raise Unavailable("not installed") from error
        axes, offsets, home = robot.reference.screws()
        self.name = f"EAIK {version('eaik')}"
        self.bot = IKRobot()
        self.bot._robot = binding.Robot(axes.T, offsets.T, home, [], True)
        # Asked before the first call: on an arm that it does not know, IK raises and IK_batched aborts the process.
        if not self.bot.hasKnownDecomposition():
            raise Unavailable("no decomposition for this arm")

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        return np.array(self.bot.IK(prepared).Q)

    def claims(self, prepared: Any) -> tuple[np.ndarray, np.ndarray]:
        """With its own least-squares flags."""
        answer = self.bot.IK(prepared)
        return np.array(answer.Q).reshape(-1, 6), np.array(answer.is_LS, dtype=bool)

    def solve_batch(self, prepared: Any, threads: int) -> Any:
        """Many poses."""
        return self.bot.IK_batched(prepared, threads)


class IkGeo(Peer):
    """ik-geo (Elias and Wen 2022, Ostermeier's Rust port)."""

    name = "ik-geo"
    single_call = "np.array([q for q, _ in bot.get_ik(R, t)])"

    def __init__(self, robot: Robot) -> None:
        """Build it from H and P; its poses carry no home rotation."""
        try:
            import ik_geo
        except ImportError as error:
            raise Unavailable("not installed") from error
        axes, offsets, self.home = robot.reference.screws()
        if robot.structure == "wrist":  # it wants the points of axes 4, 5 and 6 in the wrist's centre, the origin of 5
            offsets[3], offsets[4] = offsets[3] + offsets[4], 0.0
            offsets[6], offsets[5] = offsets[6] + offsets[5], 0.0
        self.name = f"ik-geo {version('ik-geo')}"
        kinds = {
            "wrist": "spherical_two_parallel",
            "three parallel": "three_parallel_two_intersecting",
            "general": "gen_six_dof",
        }
        maker: Any = ik_geo
        self.bot = getattr(maker.Robot, kinds[robot.structure])(axes, offsets)

    def prepare(self, target: np.ndarray) -> Any:
        """Rotation and position; version 1.0.3 reads a rotation given as an array by columns."""
        return np.ascontiguousarray((target[:3, :3] @ self.home.T).T), np.ascontiguousarray(target[:3, 3])

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        return np.array([q for q, _ in self.bot.get_ik(*prepared)])

    def claims(self, prepared: Any) -> tuple[np.ndarray, np.ndarray]:
        """With its own least-squares flags."""
        answer = self.bot.get_ik(*prepared)
        return np.array([q for q, _ in answer]).reshape(-1, 6), np.array([flag for _, flag in answer], dtype=bool)


class Opw(Peer):
    """py-opw-kinematics (Brandstoetter, Angerer and Hofbaur 2014), for ortho-parallel arms with a spherical wrist."""

    name = "py-opw"
    single_call = "np.array(bot.inverse(pose))"
    batch_call = "bot.reach(poses, threads=...).joints"

    def __init__(self, robot: Robot) -> None:
        """Build it from the ortho-parallel parameters."""
        if robot.ortho_parallel is None:
            raise Unavailable("no ortho-parallel arm")
        try:
            import py_opw_kinematics as opw
        except ImportError as error:
            raise Unavailable("not installed") from error
        self.opw = opw
        self.name = f"py-opw {version('py-opw-kinematics')}"
        p = robot.ortho_parallel
        model = opw.KinematicModel(p.a1, p.a2, p.b, p.c1, p.c2, p.c3, p.c4, offsets=p.offsets)
        self.bot = opw.Robot(model, degrees=False)

    def prepare(self, target: np.ndarray) -> Any:
        """A RigidTransform."""
        return self.opw.RigidTransform.from_matrix(target)

    def prepare_batch(self, targets: np.ndarray) -> Any:
        """A RigidTransform of many."""
        return self.prepare(targets)

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        return np.array(self.bot.inverse(prepared))

    def solve_batch(self, prepared: Any, threads: int) -> Any:
        """Many poses."""
        return self.bot.reach(prepared, threads=threads).joints


class Adapted(Peer):
    """A solver that takes a pose as it is, by the adapter with which ``urdf-ik judge`` judges it."""

    package: str
    note = ""

    def __init__(self, robot: Robot) -> None:
        """Build it from the arm; some derive a module first, for minutes where the arm is general."""
        if robot.structure == "general":
            print(f"{self.name}: preparing {robot.name}, minutes ...", file=sys.stderr, flush=True)
        try:
            arm = urdf_ik.load(robot.urdf, base="base", tip="tool")
            self.call = self.adapter(arm, robot)
        except urdf_ik.MissingPackage as error:
            raise Unavailable("not installed") from error
        except urdf_ik.UrdfIkError as error:
            raise Unavailable(str(error)) from error
        self.name = f"{self.name} {version(self.package)}{self.note}"
        self.solve(self.prepare(arm.fk(np.full(arm.dof, 0.3))))  # what is derived at the first call is not timed

    @abstractmethod
    def adapter(self, arm: urdf_ik.Arm, robot: Robot) -> Callable[[Any], Any]:
        """Its function for an arm."""

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        found: np.ndarray = self.call(prepared)
        return found


class Ssik(Adapted):
    """ssik's general entry point, which needs no build."""

    name = package = "ssik"
    single_call = "np.array([s.q for s in bot.solve(T, respect_limits=False)])"

    def adapter(self, arm: urdf_ik.Arm, robot: Robot) -> Callable[[Any], Any]:
        """From the URDF."""
        return adapters.ssik(arm)


class SsikBuilt(Adapted):
    """The module that ``ssik build`` generates for the arm: a second's work, minutes for a general arm."""

    name = package = "ssik"
    single_call = "np.array([s.q for s in arm_ik.solve(T, respect_limits=False)])"
    note = ", built"

    def adapter(self, arm: urdf_ik.Arm, robot: Robot) -> Callable[[Any], Any]:
        """Built first."""
        return adapters.ssik_built(arm)


class SsikPrebuilt(Adapted):
    """The module that ssik ships for an arm of a maker: no build, and the arm's own numbers in it."""

    name = package = "ssik"
    single_call = "np.array([s.q for s in arm_ik.solve(T, respect_limits=False, enumerate_windings=False)])"
    note = ", prebuilt"

    def adapter(self, arm: urdf_ik.Arm, robot: Robot) -> Callable[[Any], Any]:
        """Its tip is another frame of the same link, which is prepared off the clock."""
        if robot.name not in PREBUILT:
            raise Unavailable("ships no module for this arm")
        which, name, tip = PREBUILT[robot.name]
        its = urdf_ik.load(name, tip=tip)
        q = np.random.default_rng(0).uniform(-1.0, 1.0, (9, 6))
        between = np.linalg.inv(arm.fk(q)) @ its.fk(q)
        if np.ptp(between, axis=0).max() > 1e-9:
            raise Unavailable("ships a module with other lengths")
        self.between = between[0]
        return adapters.ssik_prebuilt(its, which)

    def prepare(self, target: np.ndarray) -> Any:
        """The pose of its tip."""
        return target @ self.between


class Toolbox(Adapted):
    """The Robotics Toolbox's analytic solver, in Python."""

    name, package = "Robotics Toolbox", "roboticstoolbox-python"
    single_call = "ik.solve(T, joint_limits=False).q"
    note = ", Python"

    def adapter(self, arm: urdf_ik.Arm, robot: Robot) -> Callable[[Any], Any]:
        """Derived from a table of Denavit-Hartenberg parameters."""
        return adapters.toolbox(arm)


class ToolboxInC(Toolbox):
    """The C that the Robotics Toolbox writes for the arm, called through ctypes."""

    single_call = "ikine(T, tol, q, n) in C through ctypes, and a copy of q"
    note = ", C"

    def adapter(self, arm: urdf_ik.Arm, robot: Robot) -> Callable[[Any], Any]:
        """Derived, written as C and compiled."""
        return adapters.toolbox(arm, "c")


PREBUILT = {"UR5": ("universal_robots.ur5", "ur5", "ee_link")}
"""Modules of ``ssik.prebuilt`` by the name of the benchmark's arm, and the catalogue's arm and tip that they are of."""

PEERS: tuple[type[Peer], ...] = (UrdfIk, Eaik, IkGeo, Opw, SsikPrebuilt, SsikBuilt, Ssik, ToolboxInC, Toolbox)
