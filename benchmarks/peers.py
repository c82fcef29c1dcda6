"""The solvers that the benchmark compares, behind one small interface.

Each takes a 4x4 pose and answers with a (k, 6) array of joint vectors [rad], as it stands after the shortest way that
its own documentation gives. Whatever a peer wants prepared (a pose object, another frame) is prepared off the clock.
"""

from __future__ import annotations

import importlib
import importlib.util
import subprocess
import sys
import tempfile
from abc import ABC, abstractmethod
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from robots import Robot

BUILD_TIME = 120.0  # s, after which a build counts as failed
GENERAL_BUILD_TIME = 900.0  # the same for a general arm, which takes minutes


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
        import urdf_ik

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


class Ssik(Peer):
    """ssik's general entry point, which needs no build."""

    name = "ssik"
    single_call = "np.array([s.q for s in bot.solve(T, respect_limits=False)])"

    def __init__(self, robot: Robot) -> None:
        """Read the URDF from a temporary file, since it takes no text."""
        try:
            import ssik
        except ImportError as error:
            raise Unavailable("not installed") from error
        self.name = f"ssik {version('ssik')}"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "arm.urdf")
            path.write_text(robot.urdf)
            self.bot = ssik.Manipulator.from_urdf(path, base="base", ee="tool")
        if robot.structure == "general":
            print(
                f"{self.name} derives its solver for {robot.name}: minutes, once on this machine ...",
                file=sys.stderr,
                flush=True,
            )
            self.solve(robot.reference.pose(np.full(6, 0.3)))

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        return np.array([s.q for s in self.bot.solve(prepared, respect_limits=False)])


class SsikBuilt(Peer):
    """The module that ``ssik build`` generates for the arm: a second's work, minutes for a general arm."""

    name = "ssik, built"
    single_call = "np.array([s.q for s in arm_ik.solve(T, respect_limits=False)])"

    def __init__(self, robot: Robot) -> None:
        """Generate the module in a temporary folder and import it."""
        if importlib.util.find_spec("ssik") is None:
            raise Unavailable("not installed")
        general = robot.structure == "general"
        if general:
            print(f"ssik builds a module for {robot.name}: minutes ...", file=sys.stderr, flush=True)
        self.name = f"ssik {version('ssik')}, built"
        with tempfile.TemporaryDirectory() as folder:
            urdf, out = Path(folder, "arm.urdf"), Path(folder, "arm_ik.py")
            urdf.write_text(robot.urdf)
            build = "import sys, ssik.cli; sys.exit(ssik.cli.main(sys.argv[1:]))"
            options = ["--base", "base", "--ee", "tool", "--out", str(out), "--no-validate"]
            command = [sys.executable, "-c", build, "build", str(urdf), *options]
            patience = GENERAL_BUILD_TIME if general else BUILD_TIME
            try:
                subprocess.run(command, check=True, capture_output=True, timeout=patience)
            except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
                raise Unavailable(f"no module built ({type(error).__name__})") from error
            spec = importlib.util.spec_from_file_location("arm_ik", out)
            if spec is None or spec.loader is None:
                raise Unavailable("no module built")
            self.module: Any = importlib.util.module_from_spec(spec)
            try:
                spec.loader.exec_module(self.module)
            except ImportError as error:
                raise Unavailable(f"the module built does not import ({error})") from error

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        return np.array([s.q for s in self.module.solve(prepared, respect_limits=False)])


class SsikPrebuilt(Peer):
    """The module that ssik ships for an arm of a maker: no build, and the arm's own numbers in it."""

    name = "ssik, prebuilt"
    single_call = "np.array([s.q for s in arm_ik.solve(T, respect_limits=False, enumerate_windings=False)])"

    def __init__(self, robot: Robot) -> None:
        """Import it, and hold it to the arm: the same joint vector must have the same pose but for fixed frames."""
        if importlib.util.find_spec("ssik") is None:
            raise Unavailable("not installed")
        which = PREBUILT.get(robot.name)
        if which is None:
            raise Unavailable("ships no module for this arm")
        self.name = f"ssik {version('ssik')}, prebuilt"
        self.module: Any = importlib.import_module(f"ssik.prebuilt.{which}_ik")
        q = np.full(6, 0.3)
        found = self.solve(robot.reference.pose(q)).reshape(-1, 6)
        if not len(found) or np.abs(robot.reference.pose(found[0]) - robot.reference.pose(q)).max() > 1e-6:
            raise Unavailable("ships a module with other frames")

    def solve(self, prepared: Any) -> np.ndarray:
        """One pose."""
        found = self.module.solve(prepared, respect_limits=False, enumerate_windings=False)
        return np.array([s.q for s in found])


PREBUILT = {"UR5": "universal_robots.ur5"}
"""Modules of ``ssik.prebuilt`` by the name of the benchmark's arm."""

PEERS: tuple[type[Peer], ...] = (UrdfIk, Eaik, IkGeo, Opw, SsikPrebuilt, SsikBuilt, Ssik)
