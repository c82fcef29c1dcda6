"""Configurations of controllers: published examples, and 1,000 random poses a maker with Pinocchio's flags."""

import math
from collections.abc import Callable

import numpy as np
import pinocchio
import pytest

import urdf_ik
from urdf_ik import OPW, ArgumentError, UnsupportedArm
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.typing import Array

UP = -math.pi / 2
# Published OPW parameters: Jmeyer1292/opw_kinematics (examples, issue 72), kroshu/kuka_robot_descriptions issue 111.
ARMS = {
    "abb": OPW(0.1, -0.135, 0.0, 0.615, 0.705, 0.755, 0.085, (0, 0, UP, 0, 0, 0), (1, 1, 1, 1, 1, 1)),
    "fanuc": OPW(0.312, -0.225, 0.0, 0.67, 1.075, 1.28, 0.235, (0, 0, UP, 0, 0, -math.pi), (1, 1, -1, -1, -1, -1)),
    "kuka": OPW(0.5, -0.18, 0.0, 0.86, 1.55, 1.0345, 0.305, (0, UP, 0, 0, 0, 0), (-1, 1, 1, -1, 1, -1)),
    "staubli": OPW(0.0, 0.0, 0.035, 0.32, 0.225, 0.225, 0.065, (0, 0, 0, 0, 0, 0), (1, 1, 1, 1, 1, 1)),
    "motoman": OPW(0.04, -0.04, 0.0, 0.33, 0.445, 0.44, 0.08, (0, 0, UP, 0, 0, 0), (1, 1, -1, -1, -1, -1)),
}


def arm_of(opw: OPW) -> urdf_ik.Arm:
    """The arm; joints 1, 4 and 6 turn two turns, the others one."""
    text = opw.to_urdf()
    for k in range(1, 7):
        most = "6.28318" if k in (1, 4, 6) else "3.14159265"
        limit = f'<limit lower="-{most}" upper="{most}" effort="1" velocity="1"/>'
        start = text.index(f'<joint name="joint_{k}"')
        end = text.index("</joint>", start)
        body = text[start:end].replace('type="continuous"', 'type="revolute"')
        text = text[:start] + body[: body.index("<limit")] + limit + text[end:]
    return urdf_ik.load(text)


def flags_of_pinocchio(arm: urdf_ik.Arm, q: Array) -> tuple[bool, bool, bool]:
    """Behind, below and flipped: from the places of Pinocchio's joints at q, and at q with joint 4 at zero."""
    reference = arm.cell.reference
    model, data = reference.pin_model, reference.pin_model.createData()
    straight = q.copy()
    straight[3] = 0.0
    places = []
    for vector in (q, straight):
        pinocchio.forwardKinematics(model, data, reference.configuration(vector).copy())
        places.append([data.oMi[k].copy() for k in range(7)])
    joints, level = places
    front, left = joints[1].rotation[:, 0], joints[1].rotation[:, 1]
    wrist, elbow, shoulder = (joints[k].translation for k in (5, 3, 2))
    ahead = np.cross(left, elbow - shoulder)
    under = np.cross(left, level[4].rotation[:, 2])
    return (
        bool((wrist - joints[1].translation) @ front < 0.0),
        bool((wrist - elbow) @ ahead < 0.0),
        bool(level[6].rotation[:, 2] @ under < 0.0),
    )


def written_as(vendor: str) -> Callable[[tuple[bool, bool, bool], Array], str]:
    """Each maker's text by its manual, from the flags and the joint values in degrees."""

    def abb(flags: tuple[bool, bool, bool], q: Array) -> str:
        behind, below, flipped = flags
        return " ".join(str(math.floor(q[i] / 90)) for i in (0, 3, 5)) + f" {4 * behind + 2 * below + flipped}"

    def fanuc(flags: tuple[bool, bool, bool], q: Array) -> str:
        behind, below, flipped = flags
        turns = [0 if abs(q[i]) < 180 else math.copysign(1, q[i]) for i in (0, 3, 5)]
        return f"{'NF'[flipped]}{'UD'[below]}{'TB'[behind]} " + " ".join(f"{turn:.0f}" for turn in turns)

    def kuka(flags: tuple[bool, bool, bool], q: Array) -> str:
        behind, below, flipped = flags
        turn = sum(2**i for i in range(6) if q[i] < 0)
        return f"S {behind + 2 * (not below) + 4 * (not flipped)} T {turn}"

    def staubli(flags: tuple[bool, bool, bool], q: Array) -> str:
        behind, below, flipped = flags
        elbow, wrist = ("enegative" if below else "epositive"), ("wnegative" if flipped else "wpositive")
        return f"{'lefty' if behind else 'righty'} {elbow} {wrist}"

    def motoman(flags: tuple[bool, bool, bool], q: Array) -> str:
        behind, below, flipped = flags
        first = ["FLIP" if flipped else "NOFLIP", "LOWER" if below else "UPPER", "REAR" if behind else "FRONT"]
        far = [f"{axis}{'<' if abs(q[i]) <= 180 else '>='}180" for axis, i in (("R", 3), ("T", 5), ("S", 0))]
        return ", ".join([*first, *far])

    return {"abb": abb, "fanuc": fanuc, "kuka": kuka, "staubli": staubli, "motoman": motoman}[vendor]


@pytest.mark.parametrize("vendor", ARMS)
def test_a_thousand_random_poses_there_and_back(vendor: str) -> None:
    """The one solution with the configuration is the joint vector whose flags Pinocchio's frames give."""
    arm, rng = arm_of(ARMS[vendor]), np.random.default_rng(7)
    turning = vendor != "staubli"
    for _ in range(1000):
        q = rng.uniform(-math.pi, math.pi, 6)
        if turning:
            q[[0, 3, 5]] *= 2.0
        expected = written_as(vendor)(flags_of_pinocchio(arm, q), np.rad2deg(q))
        solutions = arm.ik(arm.fk(q)).with_configuration(expected, vendor)
        assert len(solutions) == 1 and solutions.configuration(vendor)[solutions.valid].tolist() == [expected]
        if turning:
            np.testing.assert_allclose(solutions[0].q, q, atol=1e-6)


def test_names_and_flags_agree() -> None:
    """Shoulder and elbow of the branch names are the flags; where the wrist is behind, an elbow up is 'below'."""
    for opw in ARMS.values():
        arm = arm_of(opw)
        for q in np.random.default_rng(3).uniform(-3.0, 3.0, (40, 6)):
            solutions = arm.ik(arm.fk(q))
            for name, code in zip(solutions.branches, solutions.configuration("fanuc"), strict=True):
                if code:
                    assert code[2] == ("B" if "back" in name else "T")
                    assert code[1] == ("U" if ("elbow up" in name) == ("front" in name) else "D")


def test_published_positions_of_a_fanuc() -> None:
    """R-2000iB/165F (C. Strybis, "The perils of six-axis robots"): pose, NUT and FUT with the pendant's joint values.

    FANUC measures from the height of J2; the published position has a flange and tool of 0.27 m.
    """
    arm = arm_of(OPW(0.312, -0.225, 0.0, 0.0, 1.075, 1.28, 0.27, (0, 0, UP, 0, 0, -math.pi), (1, 1, -1, -1, -1, -1)))
    T = urdf_ik.pose([1.5, 0.0, 0.36], fanuc=[135.0, -45.0, 0.0], degrees=True)
    published = {
        "NUT 000": [7.962, -5.284, -36.250, 77.661, -51.975, -79.273],
        "FUT 000": [7.962, -5.284, -36.250, -102.339, 51.975, 100.727],
    }
    for written, joints in published.items():
        (solution,) = arm.ik(T).with_configuration(written, "fanuc")
        shown = np.rad2deg(solution.q)
        shown[2] -= shown[1]  # the pendant shows J3 against the horizon
        np.testing.assert_allclose(shown, joints, atol=2e-3)


def test_published_parameters_come_back() -> None:
    """Lengths, zeros and signs of each arm are those that its URDF was made from; poses are those of the formula."""
    for opw in ARMS.values():
        found = OPW.from_chain(urdf_ik.load(opw.to_urdf()).chain)
        for name in ("a1", "a2", "b", "c1", "c2", "c3", "c4"):
            assert getattr(found, name) == pytest.approx(getattr(opw, name), abs=1e-12)
        turns = (np.array(found.offsets) - opw.offsets) / (2.0 * math.pi)
        np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)
        assert found.signs == opw.signs
    # The wrist centre by the closed form of the paper, at t = (0, 0.4, 0.7, ...).
    opw = ARMS["kuka"]
    arm = urdf_ik.load(opw.to_urdf())
    t = np.array([0.0, 0.4, 0.7, 0.3, 0.0, 0.2])
    q = np.array(opw.signs) * (t + opw.offsets)
    phi, length = math.atan2(opw.a2, opw.c3), math.hypot(opw.a2, opw.c3)
    x = opw.a1 + opw.c2 * math.sin(0.4) + length * math.sin(1.1 + phi) + opw.c4 * math.sin(1.1)
    z = opw.c1 + opw.c2 * math.cos(0.4) + length * math.cos(1.1 + phi) + opw.c4 * math.cos(1.1)
    np.testing.assert_allclose(Reference(arm.model).pose(q)[:3, 3], [x, opw.b, z], atol=1e-12)


def test_quadrants_and_turns_by_the_manuals() -> None:
    """ABB: 0 is the first positive quarter, -1 the first negative one; KUKA: all axes negative are Turn 63."""
    arm = arm_of(ARMS["abb"])
    q = np.deg2rad([100.0, 10.0, 20.0, -100.0, 30.0, -10.0])
    assert arm.ik(arm.fk(q)).turns().nearest(q).configuration("abb").tolist() == ["1 -2 -1 0"]
    arm = arm_of(ARMS["kuka"])
    home = np.deg2rad([-1.0, -90.0, 90.0, -1.0, -1.0, -1.0])  # the usual home: S has bit 1, the wrist is ahead
    assert arm.ik(arm.fk(home)).nearest(home).configuration("kuka").tolist() == ["S 2 T 59"]
    negative = -np.deg2rad([10.0, 80.0, 5.0, 30.0, 20.0, 40.0])
    assert arm.ik(arm.fk(negative)).nearest(negative).configuration("kuka")[0].endswith("T 63")


@pytest.mark.parametrize(
    ("vendor", "written", "same"),
    [
        ("abb", "[0,-1,0,1]", "0 -1 0 1"),
        ("fanuc", "N U T, 0, 0, 0", "NUT 000"),
        ("kuka", "S 'B110', T 'B110110'", "S 6 T 54"),
        ("motoman", "1,0,0,0,0,0", "front, upper arm, no flip, R<180, T<180, S < 180"),
        ("staubli", "wpositive, righty", "righty wpositive"),
    ],
)
def test_spellings(vendor: str, written: str, same: str) -> None:
    """As programs of the makers write them, and as pendants show them."""
    arm = arm_of(ARMS[vendor])
    solutions = arm.ik(arm.fk([0.3, 0.2, -0.4, 0.9, 0.8, 0.5]))
    first, second = (solutions.with_configuration(each, vendor) for each in (written, same))
    np.testing.assert_array_equal(first.to_array(), second.to_array())
    # What is printed selects its own solution, outside the limits, too, alone and in a batch.
    puma = urdf_ik.load("puma_560")
    batch = puma.ik(puma.fk([[0.1, -1.0, 1.0, 0.2, 0.3, 0.0], [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]]))
    for pose, code in np.ndenumerate(batch.configuration(vendor)):
        for found in (batch[pose[0]].with_configuration(code, vendor), batch.with_configuration(code, vendor)[pose[0]]):
            assert batch.q[pose].tolist() in found.to_array().tolist() and code in found.configuration(vendor)
            assert batch.names[pose] in found.names[found.valid]


@pytest.mark.parametrize(
    ("vendor", "written"),
    [("abb", "0 0 0 8"), ("fanuc", "XUT 0 0 0"), ("kuka", "S 9 T 0"), ("motoman", "front back"), ("staubli", "up")],
)
def test_what_is_no_configuration_is_refused_with_an_example(vendor: str, written: str) -> None:
    """And so are unknown makers, and arms that have none."""
    arm = arm_of(ARMS["abb"])
    solutions = arm.ik(arm.fk([0.3, 0.2, -0.4, 0.9, 0.8, 0.5]))
    with pytest.raises(ArgumentError, match="such as"):
        solutions.with_configuration(written, vendor)
    with pytest.raises(ArgumentError, match="'kuka'"):
        solutions.configuration("kuks")
    planar = urdf_ik.load("planar_2r")
    with pytest.raises(UnsupportedArm, match="axes 2 and 3 parallel"):
        planar.ik(planar.fk([0.1, 0.2])).configuration("abb")


def test_a_missing_configuration_is_explained() -> None:
    """With those that there are."""
    arm = arm_of(ARMS["fanuc"])
    solutions = arm.ik(arm.fk([0.3, 0.2, -0.4, 0.9, -0.8, 0.5]))
    why = solutions.with_configuration("NUT 0 0 0", "fanuc").with_configuration("FDB 0 0 0", "fanuc").explain()
    assert "none with the configuration FDB 0 0 0 of fanuc; there are NUT 0 0 0" in why


def test_notations_of_the_makers() -> None:
    """Each against SciPy: fixed x y z (FANUC, Motoman), moving z y x (KUKA), moving x y z (Staubli), w first (ABB)."""
    from scipy.spatial.transform import Rotation

    angles = np.array([30.0, -40.0, 110.0])
    for vendor, axes in {"fanuc": "xyz", "motoman": "xyz", "kuka": "ZYX", "staubli": "XYZ"}.items():
        R = urdf_ik.pose([0.0, 0.0, 0.0], **{vendor: angles}, degrees=True)[:3, :3]
        np.testing.assert_allclose(R, Rotation.from_euler(axes, angles, degrees=True).as_matrix(), atol=1e-15)
        radians = urdf_ik.pose([0.0, 0.0, 0.0], **{vendor: np.deg2rad(angles)})[:3, :3]
        np.testing.assert_array_equal(R, radians)
    quaternion = [0.8, 0.2, -0.3, 0.1]
    R = urdf_ik.pose([0.0, 0.0, 0.0], abb=quaternion)[:3, :3]
    np.testing.assert_allclose(R, Rotation.from_quat(quaternion, scalar_first=True).as_matrix(), atol=1e-15)
