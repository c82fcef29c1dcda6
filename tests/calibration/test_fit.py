"""Calibrations of arms whose true URDF is known, held to Pinocchio's poses of it."""

import json

import numpy as np
import pytest
from lxml import etree
from measured import NOISE, floors, true_arm

import urdf_ik
from urdf_ik import calibration
from urdf_ik.calibration.equations import equations
from urdf_ik.calibration.measurements import Measurements
from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.derivatives import written
from urdf_ik.model import catalogue


@pytest.mark.parametrize(
    ("name", "away"),
    [
        ("puma_560", True),
        ("scara_rrpr", False),
        *(
            pytest.param(*each, marks=pytest.mark.slow)
            for each in (("puma_560", False), ("scara_rrpr", True), ("ur5", False), ("ur5", True))
        ),
        *(pytest.param("srs_7r", away, marks=pytest.mark.slow) for away in (False, True)),
    ],
)
def test_held_out_poses_are_predicted_to_the_noise(name: str, away: bool) -> None:
    """After 60 poses with 5 percent outliers, unseen poses are off by at most 1.2 of the noise; outliers are named.

    With a tracker, base and marker are fitted too.
    """
    true = true_arm(name, 1, away=away)
    q, T = true.measured(2, 60)
    wrong = [7, 30, 51]
    T[wrong, :3, 3] += 0.01
    found = urdf_ik.calibrate(true.nominal, q, T, base=away, marker=away)
    assert found.outliers == tuple(wrong)
    assert max(floors(found, *true.measured(3, 400))) < 1.2
    assert found.before.position > 10.0 * found.after.position
    assert found.validated is not None and found.validated.position < 2.0 * np.sqrt(3.0) * NOISE[0]
    assert found.noise == pytest.approx(NOISE, rel=0.3)


def test_parallel_axes_are_named_as_what_cannot_be_told_apart() -> None:
    """Where two axes are parallel, sliding one joint's frame along them is the same as sliding the next one's."""
    true = true_arm("ur5", 4)
    arm = urdf_ik.load("ur5")
    q = true.measured(5, 60)[0]
    found = urdf_ik.calibrate(arm, q, arm.fk(q))
    joints = {frozenset(part.split(" ")[0] for part in group) for group in found.unobservable}
    assert any({"shoulder_lift_joint", "elbow_joint"} <= each for each in joints)
    assert any("wrist_1_joint" in each for each in joints)
    named = {part for group in found.unobservable for part in group}
    assert named == {str(each.parameter) for each in found.changes if not each.observable}
    # Each is a change that Pinocchio's poses of the changed URDF do not show, to first order.
    geometry = written(arm.chain)
    twists = geometry.twists(q, parameters=[each.parameter for each in found.changes]).transpose(1, 0, 2)
    rank = np.linalg.matrix_rank(twists.reshape(-1, len(found.changes)), tol=1e-6)
    assert len(found.unobservable) == len(found.changes) - rank


@pytest.mark.parametrize("kind", ["pose", "position"])
def test_derivatives_are_differences_of_the_residuals(kind: str) -> None:
    """They are the central differences, also of what is fitted beside the URDF, away from the solution."""
    true = true_arm("puma_560", 6, away=True)
    q, T = true.measured(7, 12)
    given = Measurements(kind, q, T if kind == "pose" else T[:, :3, 3])
    chosen = list(written(true.nominal.chain).parameters)
    eq = equations(true.nominal.chain, given, chosen, base=True, marker=True)
    x = eq.start + np.random.default_rng(8).uniform(-0.01, 0.01, len(eq.start))
    J, h = eq.derivatives(x, given), 1e-6
    for k in range(len(x)):
        step = h * np.eye(len(x))[k]
        change = (eq.residuals(x + step, given) - eq.residuals(x - step, given)) / (2.0 * h)
        np.testing.assert_allclose(J[:, :, k], change, atol=1e-8, err_msg=str(eq.parameters[k]))


def test_positions_alone_will_do() -> None:
    """Positions fit to their noise, and predict other poses."""
    true = true_arm("puma_560", 9)
    q, T = true.measured(10, 150)
    found = urdf_ik.calibrate(true.nominal, q, T[:, :3, 3])
    assert np.sqrt(np.mean((found.arm.fk(q) - T)[:, :3, 3] ** 2)) < 1.2 * NOISE[0]
    assert found.noise[0] == pytest.approx(NOISE[0], rel=0.3)
    assert found.after.position < 0.2 * found.before.position


def test_only_the_numbers_of_origins_change_in_the_urdf(tmp_path: object) -> None:
    """Names, meshes, comments and all other text stay; the new file has the calibrated arm's poses by Pinocchio."""
    true = true_arm("puma_560", 11)
    found = urdf_ik.calibrate(true.nominal, *true.measured(12, 60))
    written, found_text = catalogue.resolve("puma_560").path.read_text(), found.urdf().decode()
    before, after = (text[text.index("<robot") :] for text in (written, found_text))
    changed = [(a, b) for a, b in zip(before.splitlines(), after.splitlines(), strict=True) if a != b]
    assert 0 < len(changed) <= 6
    assert all("<origin" in a and a.split("<origin")[0] == b.split("<origin")[0] for a, b in changed)
    assert [each.tag for each in etree.fromstring(before.encode()).iter()] == [
        each.tag for each in etree.fromstring(after.encode()).iter()
    ]


def test_offsets_are_written_into_the_origins() -> None:
    """A URDF has no offset of a joint: the new origins give the poses of shifted joints."""
    arm = urdf_ik.load("scara_rrpr")
    shift = np.array([0.01, -0.02, 0.003, 0.015])
    q = np.random.default_rng(13).uniform(-0.4, 0.4, (30, 4))
    found = urdf_ik.calibrate(arm, q, arm.fk(q + shift), fit="offsets")
    # The last joint turns about the axis of the sum of the others: with three parallel axes only their sum is told.
    np.testing.assert_allclose(found.arm.fk(q), arm.fk(q + shift), atol=1e-9)


def test_the_best_poses_tell_more_than_others() -> None:
    """Measured next, they shrink the volume of the numbers' uncertainty more than as many drawn ones."""
    true = true_arm("puma_560", 14)
    q, T = true.measured(15, 20)
    found = urdf_ik.calibrate(true.nominal, q, T)
    best = calibration.best_poses(found, 5, seed=3)[0]
    assert ((best >= true.nominal.limits[:, 0]) & (best <= true.nominal.limits[:, 1])).all()
    drawn = true.measured(16, 5)[0]

    def volume(more: np.ndarray) -> float:
        every = np.vstack([q, more])
        J = found.equations.derivatives(found.x, Measurements("pose", every, found.equations.chain.fk(every)))
        s = np.linalg.svd(J.reshape(-1, len(found.x)) / np.tile(np.repeat(found.noise, 3), len(every))[:, None])[1]
        return float(np.log(s[s > 1e-7 * s[0]]).sum())

    assert volume(best) > volume(drawn)


def test_the_report_has_every_number() -> None:
    """Each parameter stands in the text and on the page; JSON has the errors."""
    true = true_arm("zyyzyz_6r", 17)
    found = urdf_ik.calibrate(true.nominal, *true.measured(18, 40))
    text, page, read = str(found), found.to_html(), json.loads(found.to_json())
    for each in found.changes:
        assert str(each.parameter) in text and str(each.parameter) in page
    assert len(read["parameters"]) == len(found.changes)
    assert read["validated"]["position"] == found.validated.position  # type: ignore[union-attr]


def test_what_cannot_be_fitted_is_refused_in_words() -> None:
    """Too few measurements, an unknown parameter, joints in another order."""
    true = true_arm("puma_560", 19)
    q, T = true.measured(20, 60)
    with pytest.raises(ArgumentError, match="at least 5 measurements"):
        urdf_ik.calibrate(true.nominal, q[:4], T[:4])
    with pytest.raises(ArgumentError, match="joint_2"):
        urdf_ik.calibrate(true.nominal, q, T, fit=[("joint_2", "length", 0)])
    with pytest.raises(ArgumentError, match="another order than joint_1, joint_2"):
        urdf_ik.calibrate(true.nominal, q[:, ::-1].copy(), T)
