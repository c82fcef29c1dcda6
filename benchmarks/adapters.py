"""Other solvers on an arm of this package, each a function that takes a pose: adapters to judge and to time them.

Each is built from the arm's URDF or its screw axes, and called in the shortest way that its own documentation gives.
None of them is a dependency.
"""

from __future__ import annotations

import importlib
import importlib.util
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from toolbox import in_c, in_python

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, MissingPackage, UnsupportedArm, printable
from urdf_ik.model.poses import pose
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array
from urdf_ik.verify import judging

Solve = Callable[[Any], Any]

BUILD = 900.0
"""Seconds that ``ssik build`` may take: minutes for an arm without a structure."""


def eaik(arm: Arm) -> Solve:
    """EAIK (Ostermeier, Kuelz and Althoff 2025), from the screw axes.

    Raises:
        MissingPackage: it is not installed.
        UnsupportedArm: it has no decomposition for the arm.
    """
    try:
        binding, wrapper = _package("eaik.pybindings.EAIK"), _package("eaik.IK_Robot")
    except ImportError:
        raise missing("EAIK", "eaik") from None
    chain = _six(arm, "EAIK")
    robot = wrapper.IKRobot()
    robot._robot = binding.Robot(np.array(chain.H).T, np.array(chain.P).T, np.array(chain.R_tip), [], True)
    if not robot.hasKnownDecomposition():  # asked first: without one, it raises or ends the process
        raise UnsupportedArm(f"{arm.name}: EAIK has no decomposition for this arm")

    def solve(T: Array) -> tuple[Array, NDArray[np.bool_]]:
        answer = robot.IK(T)
        return np.array(answer.Q).reshape(-1, 6), np.array(answer.is_LS, dtype=np.bool_)

    return _named("EAIK", solve)


def ik_geo(arm: Arm) -> Solve:
    """ik-geo (Elias and Wen 2022, in Ostermeier's Rust port), from the screw axes.

    Raises:
        MissingPackage: it is not installed.
        UnsupportedArm: the arm has not six turning joints.
    """
    try:
        package = _package("ik_geo")
    except ImportError:
        raise missing("ik-geo", "ik-geo") from None
    chain = _six(arm, "ik-geo")
    axes, offsets, home = np.array(chain.H), np.array(chain.P), np.array(chain.R_tip)
    family, kind = arm.structure.family or "", "gen_six_dof"
    if "spherical wrist" in family and "2||3" in family:
        kind = "spherical_two_parallel"
        centre = next(np.array(each.point) for each in arm.structure.triples if each.first == 4)
        offsets = _through(offsets, slice(3, 6), centre)
    elif "2||3||4" in family and "5x6" in family:
        kind = "three_parallel_two_intersecting"
        points = np.cumsum(offsets, axis=0)
        # Where axes 5 and 6 meet: a point on axis 5 whose distance to axis 6 is least.
        along = np.linalg.lstsq(np.stack([axes[4], -axes[5]], axis=1), points[5] - points[4], rcond=None)[0]
        offsets = _through(offsets, slice(4, 6), points[4] + along[0] * axes[4])
    robot = getattr(package.Robot, kind)(axes, offsets)

    def solve(T: Array) -> tuple[Array, NDArray[np.bool_]]:
        # Version 1.0.3 reads a rotation that is an array by columns; its poses carry no home rotation.
        R = np.ascontiguousarray((T[:3, :3] @ home.T).T)
        answer = robot.get_ik(R, np.ascontiguousarray(T[:3, 3]))
        return np.array([q for q, _ in answer]).reshape(-1, 6), np.array([flag for _, flag in answer], dtype=np.bool_)

    return _named("ik-geo", solve)


def _through(offsets: Array, which: slice, point: Array) -> Array:
    """Offsets (n + 1, 3) [m] with the points of some axes at the one in which they meet, as ik-geo wants them."""
    points = np.cumsum(offsets, axis=0)
    points[which] = point
    return np.diff(np.vstack([np.zeros(3), points]), axis=0)


def ssik(arm: Arm) -> Solve:
    """Ssik's general entry point, from the URDF, without its joint limits.

    Raises:
        MissingPackage: it is not installed.
        UnsupportedArm: it does not take the arm.
    """
    try:
        package = _package("ssik")
    except ImportError:
        raise missing("ssik", "ssik") from None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "arm.urdf")
        path.write_bytes(arm.model.xml)
        try:
            robot = package.Manipulator.from_urdf(path, base=arm.base, ee=arm.tip)
        except Exception as error:  # whatever it refuses an arm with
            raise UnsupportedArm(f"{arm.name}: ssik refuses it: {printable(error, 200)}") from None
    return _named("ssik", lambda T: np.array([s.q for s in robot.solve(T, respect_limits=False)]))


def ssik_built(arm: Arm) -> Solve:
    """The module that ``ssik build`` generates for the arm: a second, or minutes for an arm without a structure.

    Raises:
        MissingPackage: it is not installed.
        UnsupportedArm: no module was built.
    """
    if importlib.util.find_spec("ssik") is None:
        raise missing("ssik", "ssik")
    with tempfile.TemporaryDirectory() as folder:
        urdf, out = Path(folder, "arm.urdf"), Path(folder, "arm_ik.py")
        urdf.write_bytes(arm.model.xml)
        build = "import sys, ssik.cli; sys.exit(ssik.cli.main(sys.argv[1:]))"
        words = ["build", str(urdf), "--base", arm.base, "--ee", arm.tip, "--out", str(out), "--no-validate"]
        try:
            subprocess.run([sys.executable, "-c", build, *words], check=True, capture_output=True, timeout=BUILD)
            spec = importlib.util.spec_from_file_location("arm_ik", out)
            assert spec is not None and spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
        except (subprocess.SubprocessError, ImportError, OSError) as error:
            raise UnsupportedArm(f"{arm.name}: ssik built no module: {printable(error, 200)}") from None
    return _named("ssik, built", lambda T: np.array([s.q for s in module.solve(T, respect_limits=False)]))


def ssik_prebuilt(arm: Arm, which: str = "") -> Solve:
    """A module that ssik ships, such as 'universal_robots.ur5' for ``ssik.prebuilt.universal_robots.ur5_ik``.

    Its arm must be the one that is judged: the same lengths, base and tip.

    Raises:
        MissingPackage: it is not installed.
        ArgumentError: there is no such module.
    """
    if importlib.util.find_spec("ssik") is None:
        raise missing("ssik", "ssik")
    try:
        module = importlib.import_module(f"ssik.prebuilt.{which}_ik")
    except ImportError:
        raise ArgumentError(f"ssik ships no {quoted(which)}; ssik-prebuilt:VENDOR.ARM is needed") from None
    options: dict[str, Any] = {"respect_limits": False, "enumerate_windings": False}
    return _named(f"ssik prebuilt {which}", lambda T: np.array([s.q for s in module.solve(T, **options)]))


def py_opw(arm: Arm) -> Solve:
    """py-opw-kinematics (Brandstoetter, Angerer and Hofbaur 2014), for ortho-parallel arms with a spherical wrist.

    Raises:
        MissingPackage: it is not installed.
        UnsupportedArm: the arm has not the axes z y y z y z, all frames aligned with the base at q = 0.
    """
    try:
        opw = _package("py_opw_kinematics")
    except ImportError:
        raise missing("py-opw-kinematics", "py-opw-kinematics") from None
    chain = _six(arm, "py-opw")
    H, points, tip = np.array(chain.H), chain.points, np.array(chain.P).sum(axis=0)
    Z, Y = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    aligned = np.abs(H - [Z, Y, Y, Z, Y, Z]).max() < 1e-9 and np.abs(np.array(chain.R_tip) - np.eye(3)).max() < 1e-9
    centre = next(
        (np.array(each.point) for each in arm.structure.triples if each.first == 4 and each.point is not None), None
    )
    if not aligned or centre is None or np.abs(points[0, :2]).max() > 1e-9 or np.abs((tip - centre)[:2]).max() > 1e-9:
        raise UnsupportedArm(f"{arm.name}: py-opw takes ortho-parallel arms whose axes are z y y z y z at q = 0")
    shoulder, elbow = points[1], points[2]
    if abs(elbow[0] - shoulder[0]) > 1e-9:
        raise UnsupportedArm(f"{arm.name}: py-opw needs the upper arm upright at q = 0")
    model = opw.KinematicModel(
        float(shoulder[0]), float(centre[0] - elbow[0]), float(centre[1]), float(shoulder[2]),
        float(elbow[2] - shoulder[2]), float(centre[2] - elbow[2]), float((tip - centre)[2]), offsets=(0.0,) * 6,
    )  # fmt: skip
    robot = opw.Robot(model, degrees=False)
    return _named("py-opw", lambda T: np.array(robot.inverse(opw.RigidTransform.from_matrix(T))))


def frankik(arm: Arm) -> Solve:
    """Frankik (He and Liu 2021), for Franka's Panda and FR3, at 60 values of joint 7, inside the joint limits.

    Raises:
        MissingPackage: it is not installed.
        UnsupportedArm: the arm is neither of the two.
    """
    try:
        package = _package("frankik")
    except ImportError:
        raise missing("frankik", "frankik") from None
    if arm.dof != 7:
        raise UnsupportedArm(f"{arm.name}: frankik takes the Panda and the FR3")
    q = np.array([0.1, -0.2, 0.3, -1.4, 0.5, 1.6, 0.7])
    forward = np.linalg.inv(arm.fk(np.zeros(7))) @ package.fk(np.zeros(7))
    if np.abs(arm.fk(q) @ forward - package.fk(q)).max() > 1e-6:
        raise UnsupportedArm(f"{arm.name}: frankik takes the Panda and the FR3, whose kinematics this arm has not")
    # Its inverse takes the flange: 45 degrees and 103.4 mm before the frame of its forward kinematics.
    flange = forward @ pose([0.0, 0.0, -0.1034], rpy=[0.0, 0.0, np.pi / 4])
    highest = arm.limits[:, 1]
    is_fr3 = bool(np.abs(highest - package.q_max_fr3).max() < np.abs(highest - package.q_max_panda).max())
    return _named("frankik", lambda T: np.array(package.ik_sample_q7(T @ flange, None, is_fr3, 60, 332.0, True)))


def toolbox(arm: Arm, language: str = "python") -> Solve:
    """The Robotics Toolbox's analytic solver, in 'python', or in the 'c' that it writes.

    Raises:
        MissingPackage: it is not installed, or there is no C compiler.
        UnsupportedArm: it derives no solver for the arm.
        ArgumentError: there is no such language.
    """
    makers = {"python": in_python, "c": in_c}
    if language not in makers:
        raise ArgumentError(f"the Robotics Toolbox in {quoted(language)}; roboticstoolbox:python or :c is needed")
    return _named(f"Robotics Toolbox, {'C' if language == 'c' else 'Python'}", makers[language](arm))


def _package(name: str) -> Any:
    """A package that need not be installed."""
    return importlib.import_module(name)


def _six(arm: Arm, solver: str) -> Any:
    if arm.dof != 6 or not arm.structure.is_6r:
        raise UnsupportedArm(f"{arm.name}: {solver} takes six turning joints")
    return arm.chain


def _named(name: str, solve: Solve) -> Solve:
    solve.__name__ = name
    return solve


PEERS: dict[str, Callable[..., Solve]] = {
    "eaik": eaik,
    "ik-geo": ik_geo,
    "frankik": frankik,
    "py-opw": py_opw,
    "roboticstoolbox": toolbox,
    "ssik": ssik,
    "ssik-built": ssik_built,
    "ssik-prebuilt": ssik_prebuilt,
}
"""Every adapter by its name."""


def solver_of(spec: str, arm: Arm) -> Solve:
    """The adapter of a name, with what follows a colon as its second argument; or a solver of ``urdf-ik judge``."""
    kind, _, rest = spec.partition(":")
    if kind not in PEERS:
        return judging.solver_of(spec)
    return PEERS[kind](arm, rest) if rest else PEERS[kind](arm)


def missing(package: str, install: str) -> MissingPackage:
    """The error that says which package a peer needs."""
    return MissingPackage(f"the solver {package} is not installed: pip install {install}")
