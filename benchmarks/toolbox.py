"""The analytic solvers of the Robotics Toolbox 1.5: in Python, and as the C that it writes.

It derives them from a table of standard Denavit-Hartenberg parameters, in seconds to minutes; with python-flint faster.
"""

from __future__ import annotations

import ctypes
import importlib
import math
import shutil
import subprocess
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import MissingPackage, UnsupportedArm, UrdfIkError, printable
from urdf_ik.kinematics.dh import DHTable
from urdf_ik.typing import Array

NAME = "roboticstoolbox-python"
_QUARTER = 1e-9
"""Angles this close [rad] to a multiple of 90 degrees are taken for one, as closed forms need them."""
_TOLERANCE = 1e-6
"""Error of a pose's entries above which its code leaves a solution out, the default of its own Python."""


def in_python(arm: Arm) -> Callable[[Any], Any]:
    """Its solver in Python: ``DHRobot.analytic_ik().solve``.

    Raises:
        MissingPackage: it is not installed.
        UnsupportedArm: it derives no solver for the arm.
    """
    _, solver = _derived(arm)
    return lambda T: solver.solve(T, joint_limits=False).q


def in_c(arm: Arm) -> Callable[[Any], Any]:
    """The C that it writes for the arm, compiled.

    Raises:
        MissingPackage: it is not installed, or there is no C compiler.
        UnsupportedArm: it derives no solver for the arm.
    """
    robot, solver = _derived(arm)
    compiler = next((path for name in ("cc", "gcc", "clang") if (path := shutil.which(name))), None)
    if compiler is None:
        raise MissingPackage("the C of the Robotics Toolbox needs a C compiler (cc)")
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "arm_ik.c"), Path(folder, "arm_ik.so")
        source.write_text(solver.generate("c", "ikine"))
        try:
            subprocess.run([compiler, "-O2", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True,
                           capture_output=True)  # fmt: skip
        except subprocess.CalledProcessError as error:
            reason = printable(error.stderr.decode(errors="replace"), 200)
            raise UnsupportedArm(f"{arm.name}: the Toolbox's C does not compile: {reason}") from None
        most = int(source.read_text().partition("#define IKINE_MAX_SOLUTIONS ")[2].split()[0])
        ikine = ctypes.CDLL(str(library)).ikine
    number = ctypes.POINTER(ctypes.c_double)
    ikine.argtypes = (number, ctypes.c_double, number, ctypes.POINTER(ctypes.c_int))
    # Its pose is that of the table's last frame in the table's first.
    before, after = np.linalg.inv(robot.base.A), np.linalg.inv(robot.tool.A)
    pose: Array = np.empty((4, 4))
    found: Array = np.empty((most, arm.dof))
    count = ctypes.c_int()
    target, out, length = pose.ctypes.data_as(number), found.ctypes.data_as(number), ctypes.byref(count)

    def solve(T: Array) -> Array:
        pose[:] = before @ T @ after
        ikine(target, _TOLERANCE, out, length)
        out_of_c: Array = found[: count.value].copy()
        return out_of_c

    return solve


def _derived(arm: Arm) -> tuple[Any, Any]:
    """The Toolbox's robot and its analytic solver."""
    try:
        package, poses = importlib.import_module("roboticstoolbox"), importlib.import_module("spatialmath")
    except ImportError:
        raise MissingPackage(f"the solver {NAME} is not installed: pip install {NAME}") from None
    if arm.dof != 6 or arm.structure.slides:
        raise UnsupportedArm(f"{arm.name}: the Toolbox's analytic solvers are for six turning joints")
    try:
        table = DHTable.from_chain(arm.chain, "standard", snap=_QUARTER)
    except UrdfIkError as error:
        raise UnsupportedArm(f"{arm.name}: no table: {error}") from None
    alpha, theta = _square(table.alpha), _square(table.theta)
    links = [package.RevoluteDH(d=table.d[k], a=table.a[k], alpha=alpha[k], offset=theta[k]) for k in range(arm.dof)]
    base, tool = (poses.SE3(frame, check=False) for frame in (table.base, table.tool))
    robot = package.DHRobot(links, name=arm.name or "arm", base=base, tool=tool)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that python-flint would be faster
            return robot, robot.analytic_ik()
    except Exception as error:  # whatever it refuses an arm with
        raise UnsupportedArm(f"{arm.name}: the Toolbox derives no solver: {printable(error, 200)}") from None


def _square(angles: Array) -> Array:
    quarter = 0.5 * math.pi
    near = quarter * np.round(angles / quarter)
    out: Array = np.where(np.abs(angles - near) < _QUARTER, near, angles)
    return out
