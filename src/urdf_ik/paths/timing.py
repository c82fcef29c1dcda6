"""Timed plans: as fast as the limits of velocity and acceleration allow."""

import csv
import io
import logging
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions.distances import per_joint
from urdf_ik.kinematics.chain import velocity_limits
from urdf_ik.paths.path_settings import velocities
from urdf_ik.support import files, inputs
from urdf_ik.support.text import json_text
from urdf_ik.typing import Array

_GRID_POINTS = 4
"""Grid points between two joint vectors of the motion at which TOPP-RA computes the speed."""


@dataclass(frozen=True)
class Timed:
    """A plan in time.

    Attributes:
        t: (k,) s.
        q: (k, n) rad or m.
        qd: (k, n) rad/s or m/s.
        qdd: (k, n) rad/s^2 or m/s^2.
        method: 'TOPP-RA', or 'scaled' where that package is not installed or the jerk is limited.
        joints: n names.
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array
    method: str
    joints: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """s: the whole time."""
        return float(self.t[-1])

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a row a sample: t [s], the joints by name, their velocities as 'NAME qd', accelerations as 'NAME qdd'.

        Raises:
            ArgumentError: the file cannot be written.
        """
        header = ["t", *(f"{name}{what}" for what in ("", " qd", " qdd") for name in self.joints)]
        write_rows(path, header, np.column_stack([self.t, self.q, self.qd, self.qdd]).tolist())

    def to_json(self) -> str:
        """As JSON: joints, t, q, qd, qdd."""
        return json_text({"joints": self.joints, "t": self.t, "q": self.q, "qd": self.qd, "qdd": self.qdd})

    def __repr__(self) -> str:
        return f"<Timed: {self.duration:.3f} s, {len(self.t)} samples, {self.method}>"


def write_rows(path: str | os.PathLike[str], header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV; numbers read back exactly."""
    text = io.StringIO()
    csv.writer(text).writerows([header, *rows])
    files.write(path, text.getvalue().encode())


MOST_SAMPLES = 10_000_000
"""Most samples of a timed plan (2.4 GB for six joints)."""


def timed(plan: Any, velocity: Any = None, acceleration: Any = None, *, dt: float = 0.01) -> Timed:
    """The plan in time, from rest to rest.

    With TOPP-RA installed (``pip install 'urdf-ik[timing]'``; Pham and Pham, "A new approach to time-optimal path
    parameterization based on reachability analysis", IEEE T-RO 34(3), 2018) the joints pass all joint vectors of
    ``plan.motion`` on a cubic spline, as fast as the limits allow. Without it, and where the URDF (1.2) limits jerks,
    the whole motion on that spline is slowed down by one factor until its sampled velocities, accelerations and jerks
    keep within the limits.

    Args:
        plan: a ``Plan`` without changes of branch.
        velocity: rad/s or m/s, a number or one a joint; default: the URDF's limits.
        acceleration: rad/s^2 or m/s^2, a number or one a joint; default: the URDF's (1.2), and where it has none, what
            reaches the velocity limit in half a second.
        dt: s between samples.

    Raises:
        ArgumentError: there is no plan, it changes its branch, or a limit or ``dt`` is missing or not positive.
    """
    if not plan.found or plan.changes:
        raise ArgumentError("only a plan that was found, without reconfigurations, can be timed")
    dt = inputs.number(dt, "dt", above=0.0, unit="s")
    solver = plan.solver
    names = solver.joint_names
    v = velocities(solver) if velocity is None else per_joint("velocity", velocity, names)
    model = plan.solver.arm.model
    stated, jerk = (velocity_limits(model, solver.chain, rate) for rate in ("acceleration", "jerk"))
    standard = np.where(np.isinf(stated), 2.0 * v, stated)
    a = standard if acceleration is None else per_joint("acceleration", acceleration, names)
    q = plan.motion
    steps = (np.abs(np.diff(q, axis=0)) / v).max(axis=1, initial=0.0)
    # A step that moves nothing takes no time, and a spline needs places that ascend.
    moving = np.concatenate([[True], steps > 0.0])
    if moving.sum() < 2:
        still = np.zeros_like(q[:1])
        return Timed(np.zeros(1), q[:1].copy(), still, still, "scaled", solver.joint_names)
    place = np.cumsum(np.concatenate([[0.0], steps[steps > 0.0]]))
    if find_spec("toppra") is None or np.isfinite(jerk).any():
        made = _scaled(q[moving], place, v, a, jerk, dt)
    else:
        made = _toppra(q[moving], place, v, a, dt)
    return replace(made, joints=solver.joint_names)


def _toppra(q: Array, place: Array, v: Array, a: Array, dt: float) -> Timed:
    toppra: Any = import_module("toppra")  # which has no type annotations
    toppra.setup_logging("ERROR")
    logging.getLogger("toppra").setLevel(logging.ERROR)
    path = toppra.SplineInterpolator(place, q)
    limits = [
        toppra.constraint.JointVelocityConstraint(np.column_stack([-v, v])),
        toppra.constraint.JointAccelerationConstraint(np.column_stack([-a, a])),
    ]
    between = np.linspace(place[:-1], place[1:], _GRID_POINTS, endpoint=False)
    planner = toppra.algorithm.TOPPRA(limits, path, gridpoints=np.append(np.unique(between), place[-1]))
    found = planner.compute_trajectory(0.0, 0.0)
    if found is None:
        raise ArgumentError(
            "no timing keeps within the limits of velocity and acceleration: the path has a corner; blend it"
        )
    t = _times(found.duration, dt)
    return Timed(t, found(t), found(t, 1), found(t, 2), "TOPP-RA")


def _scaled(q: Array, place: Array, v: Array, a: Array, jerk: Array, dt: float) -> Timed:
    """A cubic spline, of which the share s = 10 u^3 - 15 u^4 + 6 u^5 is done at the share u of the duration."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(place / place[-1], q)

    def rates(u: Array) -> tuple[Array, Array, Array, Array]:
        """Values and their derivatives by u."""
        u = u[:, None]
        s1, s2, s3 = 30 * (u - 1) ** 2 * u**2, 60 * u * (1 - 3 * u + 2 * u**2), 60 * (1 - 6 * u + 6 * u**2)
        q0, q1, q2, q3 = (spline((((6 * u - 15) * u + 10) * u**3)[:, 0], order) for order in range(4))
        return q0, q1 * s1, q2 * s1**2 + q1 * s2, q3 * s1**3 + 3 * q2 * s1 * s2 + q1 * s3

    _, speed, change, third = map(np.abs, rates(np.linspace(0.0, 1.0, max(16 * len(q), 200))))
    duration = float(max((speed / v).max(), np.sqrt((change / a).max()), np.cbrt((third / jerk).max())))
    times = _times(duration, dt)
    positions, speed, change, _ = rates(times / duration)
    return Timed(times, positions, speed / duration, change / duration**2, "scaled")


def _times(duration: float, dt: float) -> Array:
    if not duration <= MOST_SAMPLES * dt:
        raise ArgumentError(f"{duration:.3g} s at dt={dt:g} s are more than {MOST_SAMPLES} samples; take a larger dt")
    return np.append(np.arange(0.0, duration - 1e-9 * dt, dt), duration)
