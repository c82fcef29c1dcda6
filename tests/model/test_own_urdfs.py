"""The arms that this project describes itself: what they claim to be, Pinocchio must read out of the file."""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from check_urdf import run_check_urdf
from numpy.typing import NDArray
from oracle import Oracle

from urdf_ik.model import catalogue

Array = NDArray[np.float64]
ARMS = ("zyyzyz_6r", "dh_6r")
JOINTS = tuple(f"joint_{i}" for i in range(1, 7))

# The published table: alpha [rad], a [m], d [m], theta0 [rad], in the modified (Craig) convention.
DH_ROWS = (
    (0.0, 0.0, 0.1, 0.0),
    (math.pi / 2, 0.0, 0.0, 0.0),
    (0.0, 0.5, 0.0, math.pi / 2),
    (math.pi / 2, 0.0, 0.5, 0.0),
    (-math.pi / 2, 0.0, 0.0, 0.0),
    (math.pi / 2, 0.0, 0.0, 0.0),
)


def path_of(name: str) -> Path:
    """The arm's file."""
    return catalogue.resolve(name).path


def oracle_of(name: str) -> Oracle:
    """Pinocchio's view of the arm, base_link to tool0."""
    return Oracle(path_of(name), base="base_link", tip="tool0")


def draw_within_limits(oracle: Oracle, rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (m, n) [rad], uniform inside the limits."""
    return rng.uniform(oracle.model.lowerPositionLimit, oracle.model.upperPositionLimit, (m, oracle.dof))


def elementary(axis: str, angle: float = 0.0, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> Array:
    """A rotation by an angle [rad] about x, y or z, with a translation [m], as a matrix (4, 4)."""
    T = np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    T[i, i] = T[j, j] = math.cos(angle)
    T[i, j], T[j, i] = -math.sin(angle), math.sin(angle)
    T[:3, 3] = shift
    return T


def product_of(matrices: Sequence[Array]) -> Array:
    """Their product, first to last."""
    result = np.eye(4)
    for matrix in matrices:
        result = result @ matrix
    return result


# ---------------------------------------------------------------- readers


@pytest.mark.parametrize("name", ARMS)
def test_check_urdf_takes_it_without_a_warning(name: str) -> None:
    """check_urdf finds one tree from base_link to tool0 and says nothing else."""
    done = run_check_urdf(path_of(name))
    assert done.returncode == 0
    assert done.stderr == ""
    chain = ["base_link", *(f"link_{i}" for i in range(1, 7)), "tool0"]
    head, *tree = done.stdout.splitlines()
    assert head == f"robot name is: {name}"
    assert [line.split(":")[-1].split()[0] for line in tree[1:]] == chain
    assert "warn" not in done.stdout.lower()


def test_check_urdf_would_complain(tmp_path: Path) -> None:
    """A file that lacks what the arms have makes check_urdf fail: its silence on them means something."""
    broken = tmp_path / "broken.urdf"
    broken.write_text(path_of("dh_6r").read_text().replace('<parent link="link_3"/>', ""))
    assert run_check_urdf(broken).returncode != 0


@pytest.mark.parametrize("name", ARMS)
def test_pinocchio_and_yourdfpy_take_it_without_a_word(
    name: str, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    """Neither warns, logs or prints, and both see the six joints in order and all shapes."""
    path = path_of(name)
    with caplog.at_level(logging.WARNING), warnings.catch_warnings():
        warnings.simplefilter("error")
        # yourdfpy's own: it merges the shapes of every link, whatever the file, by a call that trimesh has deprecated.
        warnings.filterwarnings("ignore", r".*Scene\.dump", DeprecationWarning)
        model = pin.buildModelFromUrdf(str(path))
        shapes = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.COLLISION)
        drawn = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.VISUAL)
        robot = yourdfpy.URDF.load(str(path), build_collision_scene_graph=True, load_collision_meshes=True)
        valid = robot.validate()
    printed = capfd.readouterr()
    assert (printed.out, printed.err, caplog.records) == ("", "", [])
    assert valid and robot.errors == []
    assert tuple(model.names[1:]) == tuple(robot.actuated_joint_names) == JOINTS
    links = [f"link_{i}" for i in range(1, 7)]
    for geometry in (shapes, drawn):
        assert {model.frames[shape.parentFrame].name for shape in geometry.geometryObjects} == {"base_link", *links}


# ---------------------------------------------------------------- kinematics


def test_zyyzyz_axes_and_frames() -> None:
    """At q = 0 all frames are aligned with the base, one above the other, and the axes are z y y z y z."""
    oracle = oracle_of("zyyzyz_6r")
    heights = (0.0, 1.0, 2.0, 3.0, 3.1, 3.2, 3.3)
    pin.framesForwardKinematics(oracle.model, oracle.data, np.zeros(6))
    for link, height in zip([*(f"link_{i}" for i in range(1, 7)), "tool0"], heights, strict=True):
        placement = oracle.data.oMf[oracle.model.getFrameId(link, pin.FrameType.BODY)]
        np.testing.assert_array_equal(placement.rotation, np.eye(3))
        np.testing.assert_allclose(placement.translation, (0.0, 0.0, height), atol=1e-15)
    moved = oracle.jacobian(np.zeros(6))[3:].T
    np.testing.assert_array_equal(moved, [dict(y=(0, 1, 0), z=(0, 0, 1))[axis] for axis in "zyyzyz"])


def test_zyyzyz_forward_kinematics() -> None:
    """Pinocchio's pose is the product of six rotations about z y y z y z and of the six link lengths."""
    oracle = oracle_of("zyyzyz_6r")
    for q in draw_within_limits(oracle, np.random.default_rng(1), 50):
        steps = [
            elementary(axis, angle) @ elementary("z", shift=(0.0, 0.0, length))
            for axis, angle, length in zip("zyyzyz", q, (1.0, 1.0, 1.0, 0.1, 0.1, 0.1), strict=True)
        ]
        np.testing.assert_allclose(oracle.pose(q), product_of(steps), atol=1e-14)


def test_dh_forward_kinematics() -> None:
    """Pinocchio's pose is Rx(alpha) Tx(a) Rz(theta0 + q) Tz(d), row by row of the table, in every frame."""
    oracle = oracle_of("dh_6r")
    for q in draw_within_limits(oracle, np.random.default_rng(2), 50):
        expected = np.eye(4)
        pin.framesForwardKinematics(oracle.model, oracle.data, q)
        for i, ((alpha, a, d, theta0), angle) in enumerate(zip(DH_ROWS, q, strict=True), start=1):
            expected = expected @ elementary("x", alpha) @ elementary("x", shift=(a, 0.0, 0.0))
            expected = expected @ elementary("z", theta0 + angle) @ elementary("z", shift=(0.0, 0.0, d))
            frame = oracle.data.oMf[oracle.model.getFrameId(f"link_{i}", pin.FrameType.BODY)]
            np.testing.assert_allclose(frame.homogeneous, expected, atol=1e-14)
        np.testing.assert_allclose(oracle.pose(q), expected, atol=1e-14)


def test_dh_example_target_has_eight_solutions_within_the_limits() -> None:
    """Newton from many starts finds eight joint vectors for the published target, and the limits hold them all."""
    oracle = oracle_of("dh_6r")
    x, y, z, w = 0.0, 0.0, 0.8, 0.6
    target = pin.SE3(pin.Quaternion(w, x, y, z).matrix(), np.array([0.5, 0.11, 0.26])).homogeneous
    solutions = oracle.solutions(target, np.random.default_rng(3))
    assert len(solutions) == 8
    assert max(oracle.error(q, target) for q in solutions) < 1e-10
    assert (solutions > oracle.model.lowerPositionLimit).all()
    assert (solutions < oracle.model.upperPositionLimit).all()


@pytest.mark.parametrize("name", ARMS)
def test_poses_keep_several_solutions_within_the_limits(name: str) -> None:
    """The limits do not hide the branches: most poses of the arm can be reached in four ways and more."""
    oracle = oracle_of(name)
    rng = np.random.default_rng(4)
    counts = []
    for q in draw_within_limits(oracle, rng, 8):
        solutions = oracle.solutions(oracle.pose(q), rng, starts=60)
        inside = (solutions >= oracle.model.lowerPositionLimit) & (solutions <= oracle.model.upperPositionLimit)
        counts.append(int(inside.all(axis=1).sum()))
    assert np.median(counts) >= 4, counts


# ---------------------------------------------------------------- limits, masses, shapes


@pytest.mark.parametrize("name", ARMS)
def test_limits_are_those_of_a_machine(name: str) -> None:
    """Every joint has finite, ordered position limits around zero, and a finite speed and effort."""
    model = oracle_of(name).model
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    assert np.isfinite([lower, upper]).all()
    assert (lower <= -2.0).all() and (upper >= 2.0).all()
    for greatest in (model.velocityLimit, model.effortLimit):
        assert (greatest > 0.0).all() and np.isfinite(greatest).all()


@pytest.mark.parametrize("name", ARMS)
def test_inertias_are_those_of_a_body(name: str) -> None:
    """Each moving link has mass, and principal moments that some distribution of mass can have."""
    model = oracle_of(name).model
    for inertia in list(model.inertias)[1:]:
        smallest, middle, largest = np.linalg.eigvalsh(inertia.inertia)
        assert inertia.mass > 0.0
        assert smallest > 0.0
        assert largest < smallest + middle


class Shapes:
    """Collision shapes of an arm, as Pinocchio and coal see them; all pairs of links, neighbours included."""

    def __init__(self, name: str) -> None:
        """Read the arm's file."""
        path = str(path_of(name))
        self.model = pin.buildModelFromUrdf(path)
        self.shapes = pin.buildGeomFromUrdf(self.model, path, pin.GeometryType.COLLISION)
        links = [self.model.frames[shape.parentFrame].name for shape in self.shapes.geometryObjects]
        self.links = []
        for i, first in enumerate(links):
            for j, second in enumerate(links[:i]):
                if first != second:
                    self.shapes.addCollisionPair(pin.CollisionPair(j, i))
                    self.links.append((second, first))
        self.data, self.shape_data = self.model.createData(), self.shapes.createData()

    def touching(self, q: Array) -> set[tuple[str, str]]:
        """Pairs of links that touch at q (n,) [rad]."""
        pin.computeCollisions(self.model, self.data, self.shapes, self.shape_data, q, False)
        results = self.shape_data.collisionResults
        return {pair for pair, result in zip(self.links, results, strict=True) if result.isCollision()}


@pytest.mark.parametrize("name", ARMS)
def test_self_collision_is_real(name: str) -> None:
    """Links are clear of each other at q = 0, neighbours never touch within the limits, others sometimes do."""
    shapes = Shapes(name)
    oracle = oracle_of(name)
    chain = ["base_link", *(f"link_{i}" for i in range(1, 7))]
    assert shapes.touching(np.zeros(6)) == set()
    seen = [shapes.touching(q) for q in draw_within_limits(oracle, np.random.default_rng(5), 400)]
    assert not set().union(*seen) & set(zip(chain, chain[1:], strict=False))
    share = sum(map(bool, seen)) / len(seen)
    assert 0.02 < share < 0.5


def test_folded_forearm_hits_the_column() -> None:
    """The article's arm, leaning out and folded back at the elbow, drives its forearm into its own column."""
    assert Shapes("zyyzyz_6r").touching(np.array([0.0, 2.2, 2.5, 0.0, 0.0, 0.0])) == {
        ("link_1", "link_3"),
    }
