"""The count of what is lost: its reference is Pinocchio whatever the arm, and it catches what it is there for."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.cell.reference import Reference

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def million(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The benchmark as a module."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import million as module

    module._prepared.cache_clear()
    return module


def test_the_fast_reference_is_pinocchio(million: Any) -> None:
    """Its poses are those of the package's own Pinocchio reference, with continuous joints and without."""
    for name in ("zyyzyz_6r", "kinova"):
        arm = urdf_ik.load(name)
        Q = np.random.default_rng(1).uniform(-np.pi, np.pi, (20, 6))
        reference = million.ReferenceModel(arm.model.xml.decode(), arm.base, arm.tip)
        np.testing.assert_allclose(reference.poses(Q), Reference(arm.model, arm.base, arm.tip).pose(Q), atol=1e-14)
        J = Reference(arm.model, arm.base, arm.tip).jacobian(Q[0])
        assert reference.sigma_min(Q[0]) == pytest.approx(np.linalg.svd(J, compute_uv=False)[-1], rel=1e-9)


def test_zyyzyz_passes(million: Any) -> None:
    """On the bundled arm no solution is lost, given twice or inexact, and every solution was measured."""
    tally = million.measure(("z y y z y z", 3, 0, 50))
    assert (tally.poses, tally.solutions, tally.lost, tally.duplicates) == (50, 400, [], 0)
    assert 0.0 < max(tally.position, tally.rotation) < 1e-12
    assert tally.passed


def test_losses_duplicates_and_errors_are_counted(million: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A lost branch, a doubled one and one that is off by 1e-6 rad each show in their own column."""
    sound, reference = million._prepared("z y y z y z")
    rng = np.random.default_rng([3, 0])
    planted = million._drawn(sound, rng, 50)

    def ik(T: np.ndarray) -> Any:
        solutions = sound.ik(T)
        q, valid = np.array(solutions.q), np.array(solutions.valid)
        apart = np.abs(np.remainder(q - planted[:, None] + np.pi, 2.0 * np.pi) - np.pi).max(axis=-1)
        lost = int(apart[0].argmin())
        q[0, lost], valid[0, lost] = np.nan, False
        q[1, 2] = q[1, 3]
        q[2, 5, 0] += 1e-6
        return SimpleNamespace(q=q, valid=valid, certain=solutions.certain)

    arm = SimpleNamespace(ik=ik, jacobian=sound.jacobian)
    monkeypatch.setattr(million, "_prepared", lambda _: (arm, reference))
    tally = million.measure(("z y y z y z", 3, 0, 50))
    assert tally.lost[0][0].tolist() == planted[0].tolist()
    assert tally.duplicates == 1
    assert tally.rotation == pytest.approx(1e-6, rel=1e-3)
    assert not tally.passed


def test_the_benchmarked_arms_are_what_they_are_called(million: Any) -> None:
    """General arms have no closed form, and the calibrated one is off its family by about a millirad."""
    for robot in (million.KINOVA, million.CRX, million.HC10, million.RANDOM_6R):
        assert urdf_ik.load(robot.urdf).structure.is_general
    calibrated = urdf_ik.load(million.CALIBRATED_UR10E.urdf).structure
    assert calibrated.family.startswith("6R 2||3||4")
    assert 1e-4 < calibrated.imperfection[0] < 1e-2
