"""Arms with more than six joints and one in the middle given: a different arm for every value, each with its own plan.

Preparing a plan takes from a fraction of a millisecond (closed forms) to a second (elimination). The latest plans are
kept, so many poses at few values are as fast as with an end joint given. A search over many values prepares a plan for
each of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik._core import SelfMotion
from urdf_ik.ik.families.parts.family import FamilyMember, RedundantMember, columns
from urdf_ik.ik.families.parts.free_arm import FreeArm
from urdf_ik.ik.families.parts.written import written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.redundancy import locked_joint
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

KEPT = 1024
"""Number of plans that are kept, the most recently used ones."""
_SAMPLES = (0.137, 0.411, 0.659, 0.893)
"""Shares of the joint's range at which the family of the other joints is determined."""


def prepare(
    chain: Chain, k: int, number: int, plan_of: Callable[[Chain], FamilyMember | None]
) -> RedundantMember | None:
    """The plan that holds joint ``k``; None where the other joints have no solver.

    Args:
        chain: seven joints or more.
        k: the joint.
        number: the joint's number in texts.
        plan_of: finds the plan of the others' chain.
    """
    parameter = locked_joint(chain, k)
    low, high = parameter.range if np.isfinite(parameter.range).all() else (-chain.size, chain.size)
    name = chain.joint_names[k]

    @lru_cache(KEPT)
    def at_value(value: float) -> FamilyMember | None:
        return plan_of(chain.lock({name: value}))

    found = [at_value(low + share * (high - low)) for share in _SAMPLES]
    plans = [plan for plan in (*found, at_value(parameter.default)) if plan is not None]
    if any(plan is None for plan in found):
        return None
    first = plans[0]
    same = all(plan.branches == first.branches for plan in plans)
    branches = first.branches if same else columns(max(len(plan.branches) for plan in plans))
    inner = first.parameters if isinstance(first, RedundantMember) else ()

    def explain_at(T: Array, at: Array) -> str:
        plan = at_value(float(at[0]))
        if plan is None:
            why = "the other joints have no solver"
        else:
            why = plan.explain_at(T, at[1:]) if isinstance(plan, RedundantMember) else plan.explain(T)
        return f"with {quoted(name)} at {at[0]:.6g} {parameter.unit}: {why}"

    def value_of(Q: Array, T: Array) -> Array:
        own = parameter.wrapped(Q[:, k : k + 1])
        if not isinstance(first, RedundantMember):
            return own
        rows = []
        for q, pose in zip(Q, T, strict=True):
            plan: Any = at_value(float(q[k]))
            rows.append(plan.value_of(np.delete(q, k)[None], pose[None])[0])
        return np.hstack([own, np.array(rows).reshape(len(Q), -1)])

    parameters = (parameter, *inner)
    defaults = np.array([each.default for each in parameters])
    solver: Any = SolverAtEach(at_value, k, chain.n, len(branches), defaults)
    return RedundantMember(
        family=first.family,
        name=f"joint {number} given: {first.name}",
        reason=f"with joint {number} given, as asked, almost every value makes an arm of which {first.reason}",
        method=f"Joint {number} ({name}) is given, and the arm of the others is prepared for its value. {first.method}",
        branches=branches,
        imperfection=first.imperfection,
        error=first.error,
        solver=solver,
        parameters=parameters,
        self_motion=None if inner else SelfMotion(FreeArm(written=written(chain), given=k)),
        value_of=value_of,
        explain=lambda T: explain_at(T, defaults),
        explain_at=explain_at,
    )


class SolverAtEach:
    """Solves like a compiled solver, by a plan for each value of a joint."""

    numbers = 16

    def __init__(
        self, at_value: Callable[[float], FamilyMember | None], k: int, joints: int, branches: int, defaults: Array
    ) -> None:
        """Take the plans.

        Args:
            at_value: a value of the joint to the plan of the others.
            k: the joint's place.
            joints: how many there are with it.
            branches: columns of an answer.
            defaults: (parameters,) values where none are given, the joint's first.
        """
        self._at_value, self._k = at_value, k
        self.joints, self.branches, self.parameters = joints, branches, len(defaults)
        self._defaults = defaults

    def one(self, *_: Any) -> None:
        """None: single poses are solved by ``solve``."""

    def one_near(self, *_: Any) -> None:
        """None: single poses are solved by ``solve``."""

    def many(
        self,
        kind: Any,
        solver: Any,
        branches: tuple[str, ...],
        T: Array,
        q_ref: Array | None,
        values: Array | None,
        threads: int | None,
        out: Any,
    ) -> Any:
        """The solutions of poses (..., 4, 4) as a ``kind``, in the memory of ``out`` if given; None: one is no pose."""
        batch = T.shape[:-2]
        count = int(np.prod(batch))
        q = np.empty((count, self.branches, self.joints))
        flags = np.empty((count, self.branches), np.uint8)
        if self.solve(T.reshape(-1, 4, 4), q_ref, q, flags, values, threads or 1) >= 0:
            return None
        q, flags = q.reshape(*batch, *q.shape[1:]), flags.reshape(*batch, flags.shape[1])
        if out is None:
            return kind(solver, T, q, flags, branches, redundancy=values)
        out._poses[...], out._q[...], out._info[...] = T, q, flags
        return out

    def solve(
        self,
        T: Array,
        q_ref: Array | None,
        q: Array,
        flags: NDArray[np.uint8],
        values: Array | None = None,
        threads: int = 1,
    ) -> int:
        """Solve poses (m, 4, 4) into q (m, B, n) and flags (m, B); index of the first that is no pose, or -1."""
        given = np.tile(self._defaults, len(T)) if values is None else values
        given = given.reshape(len(T), self.parameters)
        q[...], flags[...] = np.nan, 0
        k, others = self._k, np.delete(np.arange(self.joints), self._k)
        for value in np.unique(given[:, 0]):
            rows = np.flatnonzero(given[:, 0] == value)
            plan = self._at_value(float(value))
            if plan is None:
                continue
            count = len(plan.branches)
            found, marks = np.empty((len(rows), count, len(others))), np.empty((len(rows), count), np.uint8)
            near = None if q_ref is None else np.ascontiguousarray(q_ref[others])
            rest = np.ascontiguousarray(given[rows, 1:]).reshape(-1) if self.parameters > 1 else None
            bad = plan.solver.solve(np.ascontiguousarray(T[rows]), near, found, marks, rest, threads)
            if bad >= 0:
                return int(rows[bad])
            count = min(count, self.branches)
            q[rows[:, None, None], np.arange(count)[:, None], others] = found[:, :count]
            q[rows, :count, k] = np.where(marks[:, :count] & 1, value, np.nan)
            flags[rows, :count] = marks[:, :count]
        return -1
