"""The assertion that an arm agrees with Pinocchio, for your own test suite.

>>> from urdf_ik.verify.testing import assert_agrees_with_pinocchio
>>> report = assert_agrees_with_pinocchio("planar_2r", n=20)

``pytest --urdf FILE --base LINK --tip LINK`` does the same without a test file, one test a property.
"""

import os
from collections.abc import Mapping, Sequence
from typing import IO, Any

from urdf_ik.arm import Arm, load
from urdf_ik.errors import ArgumentError
from urdf_ik.verify.crosscheck import CrossCheck, check

__all__ = ["assert_agrees_with_pinocchio", "verdict"]

# Without these, nothing is known of the solutions; collision may be left out where there are no shapes.
_ESSENTIAL = ("all else", "inverse kinematics")


def assert_agrees_with_pinocchio(
    urdf: Arm | str | os.PathLike[str] | IO[Any],
    *,
    base: str | None = None,
    tip: str | None = None,
    n: int = 200,
    seed: int = 0,
    collision: bool | None = None,
    locked: Mapping[str, float] | None = None,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
) -> CrossCheck:
    """Fail unless this package and Pinocchio agree on an arm: see :func:`urdf_ik.verify.crosscheck.check`.

    Args:
        urdf: what :func:`urdf_ik.load` takes, or an arm that it returned.
        base: base link; default: the root, where only one chain comes into question.
        tip: tip link; default: the end of the only movable chain.
        n: number of random poses.
        seed: of the joint vectors that make them.
        collision: compare collision, too; None: where the URDF has collision shapes and all of them can be read.
        locked: joints that are held at these values [rad or m].
        mesh_roots: folders that meshes may be read from, besides the URDF's own.

    Returns:
        The report, all of whose properties hold.

    Raises:
        AssertionError: a property does not hold, or the arm cannot be solved; the message is the report, with the pose
            and joint vector of each failure.
        UrdfIkError: the URDF, a link or a number is invalid; see :func:`urdf_ik.load`.

    Example:
        >>> assert_agrees_with_pinocchio("planar_2r", n=20).passed
        True
    """
    __tracebackhide__ = True  # pytest shows the caller's line instead
    arm = urdf
    if not isinstance(arm, Arm):
        arm = load(arm, base=base, tip=tip, locked=locked, mesh_roots=mesh_roots)
    report = check(arm, n=n, seed=seed, collision=collision)
    if not report.passed or any(name in _ESSENTIAL for name, _ in report.skipped):
        raise AssertionError(f"urdf-ik and Pinocchio do not agree:\n{report}")
    return report


def verdict(report: CrossCheck, name: str) -> tuple[bool | None, str]:
    """The verdict of a report on one of ``crosscheck.PROPERTIES``.

    Returns:
        Whether the property holds, None if it was skipped; and its worst value with the place, or the reason.
    """
    for row in report.rows:
        if row.name == name:
            worst = f"{row.name}: worst {row.worst:.2g} {row.unit}, {row.tolerance:.2g} allowed, {row.checked} checked"
            return row.passed, f"{worst}\n{row.place()}".rstrip()
    own_first = sorted(report.skipped, key=lambda skipped: not name.startswith(skipped[0]))
    for group, reason in own_first:
        if group in _ESSENTIAL or name.startswith(group):
            return (False if group in _ESSENTIAL else None), f"not checked: {group}: {reason}"
    raise ArgumentError(f"{name!r} is no property; there are: {', '.join(row.name for row in report.rows)}")
