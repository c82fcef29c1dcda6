"""The benchmark that counts lost solutions: its reference is Pinocchio, and it counts each kind of fault."""

import importlib
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def million(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The benchmark as a module."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    monkeypatch.delitem(sys.modules, "million", raising=False)  # it keeps the arm that it measured last
    return importlib.import_module("million")


def test_the_fast_reference_is_pinocchio(million: Any) -> None:
    """Its poses are those of the package's own Pinocchio reference, with continuous joints and without."""
    for name in ("zyyzyz_6r", "kinova"):
        arm = urdf_ik.load(name)
        Q = np.random.default_rng(1).uniform(-np.pi, np.pi, (20, 6))
        reference = million.ReferenceModel(arm.model.xml.decode(), arm.base, arm.tip)
        np.testing.assert_allclose(reference.poses(Q), Reference(arm.model, arm.base, arm.tip).pose(Q), atol=1e-14)
        J = Reference(arm.model, arm.base, arm.tip).jacobian(Q[0])
        assert reference.sigma_min(Q[0]) == pytest.approx(np.linalg.svd(J, compute_uv=False)[-1], rel=1e-9)


def test_losses_duplicates_and_errors_are_counted(million: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pose without solutions, a solution given twice and one that is off by 1e-6 rad each count in their column."""
    sound = urdf_ik.load("zyyzyz_6r")
    asked = []

    def ik(T: np.ndarray) -> Any:
        solutions = sound.ik(T)
        if T.ndim == 2:
            return solutions
        asked.append(T)
        q, valid = np.array(solutions.q), np.array(solutions.valid)
        q[0], valid[0] = np.nan, False
        q[1, 2] = q[1, 3]
        q[2, 5, 0] += 1e-6
        return SimpleNamespace(q=q, valid=valid, certain=solutions.certain)

    kept = {name: getattr(sound, name) for name in ("fk", "jacobian", "model", "base", "tip")}
    monkeypatch.setattr(urdf_ik, "load", lambda _: SimpleNamespace(ik=ik, **kept))
    tally = million.measure(("z y y z y z", 3, 0, 50))
    np.testing.assert_allclose(sound.fk(tally.lost[0][0]), asked[0][0], atol=1e-12)
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
