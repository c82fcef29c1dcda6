"""Two models of one arm with other frames, zeros and signs are one mechanism after aligning."""

import json
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from oracle import Oracle
from scipy.spatial.transform import Rotation

import urdf_ik
from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.verify.alignment import aligned
from urdf_ik.verify.comparison import Comparison, compare
from urdf_ik.verify.description import matrix

SHAPES = "limits,collisions,visuals"


def by_another_author(arm: Arm, seed: int, stretched: float = 0.0) -> str:
    """The arm's URDF with other zeros and signs of its joints, another base and another tip frame.

    ``stretched``: how much further from the first joint the second one is [m], along x.
    """
    rng = np.random.default_rng(seed)
    robot = etree.fromstring(arm.model.xml)

    def moved(element: etree._Element, R: Rotation, xyz: np.ndarray) -> None:
        origin = element.find("origin")
        if origin is None:
            origin = etree.SubElement(element, "origin")
        rpy, at = (np.array((origin.get(name) or "0 0 0").split(), dtype=float) for name in ("rpy", "xyz"))
        written = Rotation.from_euler("xyz", rpy)
        origin.set("rpy", " ".join(map(repr, map(float, (written * R).as_euler("xyz")))))
        origin.set("xyz", " ".join(map(repr, map(float, at + written.apply(xyz)))))

    for k, name in enumerate(arm.joint_names):
        element = next(each for each in robot.iterfind("joint") if each.get("name") == name)
        axis = np.array(element.find("axis").get("xyz").split(), dtype=float)
        value = rng.uniform(-1.0, 1.0)
        slides = bool(arm.chain.prismatic[k])
        step = np.array([stretched if k == 1 else 0.0, 0.0, 0.0])
        moved(
            element, Rotation.identity() if slides else Rotation.from_rotvec(value * axis), step + slides * value * axis
        )
        element.find("axis").set("xyz", " ".join(map(str, rng.choice([-1.0, 1.0]) * axis)))
    for end, link in (("other_base", arm.base), ("other_tip", arm.tip)):
        etree.SubElement(robot, "link", name=end)
        fixed = etree.SubElement(robot, "joint", name=f"to_{end}", type="fixed")
        etree.SubElement(fixed, "parent", link=link)
        etree.SubElement(fixed, "child", link=end)
        moved(fixed, Rotation.random(random_state=seed), rng.uniform(-0.5, 0.5, 3))
    return etree.tostring(robot).decode()


@pytest.mark.parametrize("name", ["puma_560", "scara_rrpr", "stanford_rrprrr", "srs_7r", "rail_6r", "planar_2r"])
def test_conventions_are_found_and_pinocchio_agrees(name: str, tmp_path: Path) -> None:
    """At random joint vectors A's tip is where the fit says that B's is, by Pinocchio's model of both files."""
    a = urdf_ik.load(name)
    (tmp_path / "b.urdf").write_text(by_another_author(a, 3))
    b = urdf_ik.load(tmp_path / "b.urdf", "other_base", "other_tip")
    assert not compare(a, b, n=2, ignore=(*SHAPES.split(","), "names")).same
    found = compare(a, b, n=2, ignore=SHAPES, align=True)
    assert found.same, found
    fit = found.alignment
    assert fit is not None
    ours, theirs = Oracle(a.model.path, a.base, a.tip), Oracle(tmp_path / "b.urdf", b.base, b.tip)
    for q in np.random.default_rng(0).uniform(-1.0, 1.0, (20, a.dof)):
        there = matrix(fit.base) @ theirs.pose(np.multiply(fit.signs, q) + fit.zeros) @ matrix(fit.tip)
        np.testing.assert_allclose(there, ours.pose(q), atol=1e-9)
    assert Comparison.from_dict(json.loads(found.to_json())) == found


def test_another_mechanism_stays_another() -> None:
    """A second joint 1 mm further out is a difference, which the verdict gives as that of the tips."""
    a = urdf_ik.load("puma_560")
    b = urdf_ik.load(by_another_author(a, 5, stretched=1e-3), "other_base", "other_tip")
    found = compare(a, b, n=5, ignore=SHAPES, align=True)
    assert {difference.kind for difference in found.differences} == {"kinematics"}
    assert found.tool is not None and 1e-4 < found.tool.position[2] < 3e-3
    assert found.verdict().startswith("after aligning, the tips are ")
    assert "aligned first: B in the conventions of A" in str(found)
    assert compare(a, b, n=5, ignore=SHAPES, align=True, tolerance_mm=5.0, tolerance_deg=1.0).same


def test_mjcf_urdf_and_compiled_arm_are_compared(tmp_path: Path) -> None:
    """A MuJoCo model with a turned base and other zeros, and the arm's compiled file, are the arm."""
    pytest.importorskip("mujoco")
    urdf = urdf_ik.load("planar_2r_unit")
    (tmp_path / "arm.xml").write_text(
        '<mujoco><worldbody><body name="a" euler="0 0 90"><joint name="j" axis="0 0 1"/><geom size="1" mass="1"/>'
        '<body name="b" pos="0 1 0"><joint name="k" axis="0 0 -1"/><geom size="1" mass="1"/>'
        '<body name="tool" pos="1 0 0"><geom size="1" mass="1"/></body></body></body></worldbody></mujoco>'
    )
    mjcf = urdf_ik.load(tmp_path / "arm.xml", tip="tool")
    found = compare(urdf, mjcf, n=5, ignore=SHAPES, align=True)
    assert [each for each in found.differences if each.distance or each.angle] == []
    assert found.alignment is not None and found.tool is not None
    assert found.alignment.signs[0] != found.alignment.signs[1] and found.tool.position[2] < 1e-9
    compiled = urdf_ik.load_compiled(urdf_ik.compile(urdf))
    assert aligned(urdf, compiled)[1].signs == aligned(compiled, urdf)[1].signs == (1.0, 1.0)


def test_arms_of_other_joints_are_refused() -> None:
    """Numbers or kinds of joints differ."""
    for name in ("scara_rrpr", "planar_2r"):
        with pytest.raises(ArgumentError, match="same kinds of joints"):
            compare(urdf_ik.load("puma_560"), urdf_ik.load(name), align=True)
