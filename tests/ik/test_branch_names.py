"""Names of branches are geometry: front, back, up and down are where Pinocchio puts the links."""

import itertools
import re

import numpy as np
import pinocchio as pin
import pytest
from cases import from_catalogue
from chains import joint, robot

import urdf_ik
from urdf_ik.model import catalogue

# Shoulder and wrist far from the shoulder's axis, where the sides are clear.
LOW, HIGH = (-2.5, 0.3, 0.5, -2.5, 0.3, -2.5), (2.5, 1.2, 1.8, 2.5, 1.8, 2.5)


def is_named_right(arm: urdf_ik.Arm, draws: np.ndarray) -> int:
    """Number of pairs in front that differ in the elbow alone: of each, Pinocchio puts the elbow named up higher."""
    model = arm.cell.reference.pin_model
    data, elbow = model.createData(), model.getJointId(arm.joint_names[2])

    def height(q: np.ndarray) -> float:
        pin.forwardKinematics(model, data, arm.to_pinocchio(q))
        return float(data.oMi[elbow].translation[2])

    pairs = 0
    for q in draws:
        found = {one.branch: one.q for one in arm.ik(arm.fk(q))}
        for name in [name for name in found if "front, elbow up" in name]:
            if (down := found.get(name.replace("elbow up", "elbow down"))) is not None:
                assert height(found[name]) > height(down), (name, q)
                pairs += 1
    return pairs


EIGHT = list(itertools.product((1, -1), repeat=3))
SIGNS = [(*first, *last) for first, last in zip(EIGHT, EIGHT[::-1], strict=True)]


@pytest.mark.parametrize("signs", SIGNS, ids=str)
def test_up_is_the_higher_elbow_whatever_the_signs_of_the_axes(signs: tuple[int, ...]) -> None:
    """Negating axes and the joints' values changes no name."""
    text = catalogue.resolve("zyyzyz_6r").path.read_text()
    for k, sign in enumerate(signs, 1):
        if sign < 0:
            joint = re.search(rf'<joint name="joint_{k}".*?</joint>', text, re.DOTALL)
            assert joint is not None
            x, y, z = map(float, re.search(r'<axis xyz="([^"]+)"', joint[0])[1].split())
            turned = re.sub(r'<axis xyz="[^"]+"', f'<axis xyz="{-x} {-y} {-z}"', joint[0])
            turned = re.sub(r'lower="([^"]+)" upper="([^"]+)"', r'lower="-5" upper="5"', turned)
            text = text.replace(joint[0], turned)
    flipped, plain = urdf_ik.load(text), urdf_ik.load("zyyzyz_6r")
    draws = np.random.default_rng(4).uniform(LOW, HIGH, (20, 6))
    assert is_named_right(flipped, draws * signs) > 30
    for q in draws:
        names = {one.branch: one.q for one in plain.ik(plain.fk(q))}
        others = {one.branch: one.q * signs for one in flipped.ik(plain.fk(q))}
        assert names.keys() == others.keys()
        for name, vector in names.items():
            turns = (vector - others[name]) / (2.0 * np.pi)
            assert np.abs(turns - turns.round()).max() < 1e-9


def six_joints(kind: str, seed: int) -> str:
    """A URDF of random lengths and axes of random signs: the wrist of a UR, or one through a point."""
    rng = np.random.default_rng(seed)
    a, b, c, upper, lower = rng.uniform((-0.05, -0.1, 0.05, 0.3, 0.3), (0.1, 0.1, 0.15, 0.7, 0.7))
    axes = "zyyyzy" if kind == "ur" else "zyyxyx"
    places = {
        "ur": [(0, b, c), (upper, 0, 0), (lower, 0, 0), (0, b, 0), (0, 0, -c), (0, c, 0)],
        "point": [(a, b, c), (0, 0, upper), (lower, 0, a), (0, 0, 0), (0, 0, 0), (c, 0, 0)],
    }[kind]
    joints = [
        joint(f"j{k}", "continuous" if k < 7 else "fixed", f"l{k - 1}", f"l{k}", " ".join(map(str, xyz)), axis=axis)
        for k, (xyz, axis) in enumerate(
            zip(
                [(0, 0, 0.1), *places],
                [" ".join(str(rng.choice((-1, 1)) * (axis == each)) for each in "xyz") for axis in axes] + [""],
                strict=True,
            ),
            1,
        )
    ]
    return robot(*joints)


@pytest.mark.parametrize("seed", range(18))
@pytest.mark.parametrize("kind", ["ur", "point"])
def test_up_is_above_the_line_from_shoulder_to_wrist(kind: str, seed: int) -> None:
    """Seen with the wrist in front, of 36 arms: where Pinocchio puts shoulder, elbow and wrist."""
    assert_up_is_above(urdf_ik.load(six_joints(kind, seed)), "ur" in kind)


@pytest.mark.parametrize("name", ["ur3", "ur5", "ur10", "puma_560", "zyyzyz_6r"])
def test_up_is_above_the_line_of_arms_in_use(name: str) -> None:
    """The same of arms that people have."""
    assert_up_is_above(from_catalogue(name).arm, "ur" in name)


def assert_up_is_above(arm: urdf_ik.Arm, ur: bool) -> None:
    """Of every solution with its wrist well off axis 1, the name says where Pinocchio puts the elbow."""
    model = arm.cell.reference.pin_model
    data, up = model.createData(), [0.0, 0.0, 1.0]
    joints = [model.getJointId(name) for name in arm.joint_names]
    seen = 0
    for q in np.random.default_rng(4).uniform(-2.5, 2.5, (12, 6)):
        for one in arm.ik(arm.fk(q)):
            pin.computeJointJacobians(model, data, arm.to_pinocchio(one.q))
            across = pin.getJointJacobian(model, data, joints[1], pin.LOCAL_WORLD_ALIGNED)[3:, model.idx_vs[joints[1]]]
            base, shoulder, elbow, wrist = (data.oMi[joints[k]].translation for k in (0, 1, 2, 3 if ur else 4))
            forward = np.cross(across, up)
            forward *= np.sign(forward @ (wrist - base))
            if forward @ (wrist - base) > 0.3:
                line, corner = wrist - shoulder, elbow - shoulder
                above = (line @ forward) * (corner @ up) - (line @ up) * (corner @ forward) > 0.0
                assert above == ("elbow up" in one.branch), (one.branch, one.q)
                seen += 1
    assert seen > 10


def test_front_is_where_a_ur_reaches_at_zero() -> None:
    """A UR lies along its forward side at zero: a posture that reaches to that side is in front."""
    arm = from_catalogue("ur5").arm
    q = np.array([0.4, -0.6, 1.0, -0.8, 0.9, 0.2])
    name = next(one.branch for one in arm.ik(arm.fk(q)) if np.abs(one.q - q).max() < 1e-9)
    assert name.startswith("shoulder front, elbow up")


@pytest.mark.parametrize("name", ["puma_560", "zyyzyz_6r"])
def test_front_and_noflip_are_the_t_and_n_of_a_controller(name: str) -> None:
    """FANUC's letters, which are tested against Pinocchio's frames, say of each solution what its name says."""
    arm = from_catalogue(name).arm
    for q in np.random.default_rng(8).uniform(-2.0, 2.0, (20, 6)):
        found = arm.ik(arm.fk(q))
        texts = found.configuration("fanuc")
        for one, text in zip(found, texts[texts != ""], strict=True):
            assert (text[0] == "N", text[2] == "T") == ("noflip" in one.branch, "front" in one.branch)


@pytest.mark.parametrize("name", ["ur5", "ur10", "ur3"])
def test_a_wrist_that_is_no_flip_points_the_tool_down(name: str) -> None:
    """Of a UR, with axis 5 leading forward from joint 4: Pinocchio puts the tool below the wrist, or above it."""
    arm = from_catalogue(name).arm
    model = arm.cell.reference.pin_model
    data = model.createData()
    five, six = (model.getJointId(each) for each in arm.joint_names[4:])
    tip = model.getFrameId(arm.tip)
    for q in np.random.default_rng(8).uniform(-2.0, 2.0, (20, 6)):
        for one in arm.ik(arm.fk(q)):
            v = one.q.copy()
            # At joint 1 = 0 a UR faces the side where it lies at zero.
            v[0] = 0.0
            ahead = np.sign(arm.fk(np.zeros(6))[0, 3])
            turns = []
            for v[3] in np.linspace(-np.pi, np.pi, 73):
                pin.framesForwardKinematics(model, data, arm.to_pinocchio(v))
                lead = data.oMi[six].translation - data.oMi[five].translation
                tool = data.oMf[tip].translation - data.oMi[six].translation
                turns.append((ahead * lead[0], tool[2]))
            assert (max(turns)[1] < 0.0) == ("noflip" in one.branch)
