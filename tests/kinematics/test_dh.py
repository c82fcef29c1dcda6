"""Denavit-Hartenberg tables: to URDF and back, in both conventions, with Pinocchio's poses as the reference."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from arms import serial_urdf
from command import succeed
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import DHTable, pose
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UrdfError

Array = NDArray[np.float64]
PI = math.pi
CONVENTIONS = ("standard", "modified")

# The published table of dh_6r: alpha [rad], a [m], d [m], theta [rad].
DH_6R = (
    (0.0, 0.0, 0.1, 0.0),
    (PI / 2, 0.0, 0.0, 0.0),
    (0.0, 0.5, 0.0, PI / 2),
    (PI / 2, 0.0, 0.5, 0.0),
    (-PI / 2, 0.0, 0.0, 0.0),
    (PI / 2, 0.0, 0.0, 0.0),
)


# ---------------------------------------------------------------- the formula, written out once more


def elementary(axis: str, angle: float, shift: float) -> Array:
    """Rotation about x or z by an angle [rad] and translation along it [m], as a matrix (4, 4)."""
    c, s = math.cos(angle), math.sin(angle)
    if axis == "x":
        return np.array([[1, 0, 0, shift], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, shift], [0, 0, 0, 1.0]])


def by_the_book(table: DHTable, q: Array) -> Array:
    """Pose of the tip: the product of the rows' matrices between base and tool."""
    T = table.base
    for i, kind in enumerate(table.joint_types):
        slides = kind == "prismatic"
        x = elementary("x", table.alpha[i], table.a[i])
        z = elementary("z", table.theta[i] + (0 if slides else q[i]), table.d[i] + (q[i] if slides else 0))
        T = T @ (z @ x if table.convention == "standard" else x @ z)
    return T @ table.tool


def assert_same_arm(text: str, poses: Callable[[Array], Array], rng: np.random.Generator, size: float) -> None:
    """Pinocchio's poses of the URDF text are the expected ones to 1e-12 of the arm's size."""
    reference = Reference(text, "base_link", "tool0")
    for q in rng.uniform(-PI, PI, (6, reference.dof)):
        apart = reference.pose(q) - poses(q)
        apart[:3, 3] /= size
        assert np.abs(apart).max() <= 1e-12


def random_table(rng: np.random.Generator, convention: str, n: int) -> DHTable:
    """A table full of special cases: parallel, opposite, one and meeting axes, prismatic joints, base and tool."""
    special = rng.uniform(size=n) < 0.7
    alpha = np.where(special, rng.choice([0.0, PI / 2, -PI / 2, PI], n), rng.uniform(-PI, PI, n))
    alpha = np.where(np.abs(np.sin(alpha)) < 0.05, np.round(alpha / PI) * PI, alpha)
    a, d = (np.where(rng.uniform(size=n) < 0.5, 0.0, rng.uniform(-1.0, 1.0, n)) for _ in range(2))
    theta = np.where(rng.uniform(size=n) < 0.4, rng.uniform(-PI, PI, n), rng.choice([0.0, PI / 2, PI], n))
    frames = [
        None if rng.uniform() < 0.4 else pose(rng.uniform(-0.5, 0.5, 3), rpy=rng.uniform(-PI, PI, 3)) for _ in range(2)
    ]
    return DHTable.from_array(
        np.stack([alpha, a, d, theta], axis=1),
        convention,
        joint_types="".join(rng.choice(list("RRRP"), n)),
        limits=[(-1.0, 2.0)] * n,
        base=frames[0],
        tool=frames[1],
        name="random",
    )


# ---------------------------------------------------------------- there and back


@settings(max_examples=40)  # each builds four models
@given(seed=st.integers(0, 2**32 - 1), convention=st.sampled_from(CONVENTIONS), n=st.integers(1, 7))
def test_table_to_urdf_and_back(seed: int, convention: str, n: int) -> None:
    """Table, URDF, chain, table of either convention, URDF: Pinocchio's poses stay those of the book's formula."""
    rng = np.random.default_rng(seed)
    table = random_table(rng, convention, n)
    text = table.to_urdf()
    arm = urdf_ik.load(text)
    assert arm.joint_names == table.joint_names
    assert arm.chain.joint_types == table.joint_types
    np.testing.assert_array_equal(arm.limits, table.limits)
    assert_same_arm(text, lambda q: by_the_book(table, q), rng, arm.chain.size)
    for other in CONVENTIONS:
        again = DHTable.from_chain(arm.chain, other)
        assert again.convention == other
        assert again.deviation(arm.chain) <= 1e-12
        np.testing.assert_array_equal(again.limits, table.limits)
        assert_same_arm(again.to_urdf(), lambda q: by_the_book(table, q), rng, arm.chain.size)


@given(seed=st.integers(0, 2**32 - 1))
def test_any_chain_to_table(seed: int) -> None:
    """Joints with oblique axes and frames anywhere, seen from either end: the table has the same poses."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 8))
    origins = [(rng.uniform(-1, 1, 3), rng.uniform(-1.5, 1.5, 3)) for _ in range(n + 1)]
    axes = [rng.normal(size=3) for _ in range(n)]
    links = ["base_link", *(f"l{i}" for i in range(n)), "tool0"]
    arm = urdf_ik.load(serial_urdf("any", origins, [*axes, None], links=links))
    for chain in (arm.chain, arm.chain.reversed()):
        table = DHTable.from_chain(chain, str(rng.choice(CONVENTIONS)))
        # Two axes nearly parallel cost digits: the feet of their common normal are far away.
        bends = np.linalg.norm(np.cross(chain.H[:-1], chain.H[1:]), axis=1)
        assert table.deviation(chain) <= 1e-14 / min(bends, default=1.0)
        np.testing.assert_allclose(table.fk(np.zeros(n)), chain.fk(np.zeros(n)), atol=1e-12)


@pytest.mark.parametrize("name", ["ur5", "panda", "kinova", "xarm7", "z1", "so100", "pr2_left", "talos_right"])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_arms_of_the_catalogue(name: str, convention: str) -> None:
    """Real arms: the table's URDF has the poses that Pinocchio computes from theirs."""
    arm = urdf_ik.load(name)
    theirs = Reference(arm.model, arm.base, arm.tip)
    text = DHTable.from_chain(arm.chain, convention).to_urdf()
    # Kinova's decimals leave axes 2 and 3 a little off parallel, which costs digits.
    ours = Reference(text, "base_link", "tool0")
    for q in np.random.default_rng(0).uniform(-2.0, 2.0, (10, arm.dof)):
        np.testing.assert_allclose(ours.pose(q), theirs.pose(q), atol=1e-9 if name == "kinova" else 1e-12)


# ---------------------------------------------------------------- known tables


def test_published_table_of_dh_6r_comes_back() -> None:
    """The URDF that was written by hand from the modified table gives that table, number by number."""
    table = DHTable.from_chain(urdf_ik.load("dh_6r").chain, "modified")
    rows = np.stack([table.alpha, table.a, table.d, table.theta], axis=1)
    np.testing.assert_allclose(rows, DH_6R, atol=1e-15)
    np.testing.assert_array_equal(table.base, np.eye(4))
    np.testing.assert_array_equal(table.tool, np.eye(4))


def test_published_table_of_the_panda_comes_back() -> None:
    """Franka's documentation: modified alpha, a, d of the seven joints; 0.107 m to the flange, 0.1034 m to the TCP."""
    table = DHTable.from_chain(urdf_ik.load("panda").chain, "modified")
    quarter = PI / 2
    np.testing.assert_allclose(table.alpha, [0, -quarter, quarter, quarter, -quarter, quarter, quarter], atol=1e-12)
    np.testing.assert_allclose(table.a, [0, 0, 0, 0.0825, -0.0825, 0, 0.088], atol=1e-12)
    np.testing.assert_allclose(table.d, [0.333, 0, 0.316, 0, 0.384, 0, 0.107 + 0.1034], atol=1e-12)
    np.testing.assert_allclose(table.theta, [0, 0, 0, 0, 0, 0, -PI / 4], atol=1e-12)


# ---------------------------------------------------------------- files


@given(seed=st.integers(0, 2**32 - 1), convention=st.sampled_from(CONVENTIONS))
def test_files_hold_every_digit(seed: int, convention: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    """A CSV reads back as it was written: exactly in rad, to rounding in degrees."""
    table = random_table(np.random.default_rng(seed), convention, 4)
    folder = tmp_path_factory.mktemp("tables")
    for degrees in (False, True):
        (folder / "t.csv").write_text(table.to_csv(degrees=degrees))
        again = DHTable.read(folder / "t.csv")
        for field in ("alpha", "a", "d", "theta", "limits", "base", "tool"):
            np.testing.assert_allclose(getattr(again, field), getattr(table, field), rtol=0, atol=2e-15, err_msg=field)
        assert (again.joint_types, again.joint_names) == (table.joint_types, table.joint_names)
        assert (again.convention, again.name) == (convention, "random")


def test_csv_by_hand(tmp_path: Path) -> None:
    """Columns in any order, an offset that is added to what the joint moves, the convention from the caller."""
    path = tmp_path / "hand.csv"
    path.write_text("theta,d,a,alpha,type,offset,lower,upper\n10,0.1,0,90,R,20,,\n0,0.2,0,0,P,0.3,0,1\n")
    table = DHTable.read(path, "standard", degrees=True)
    np.testing.assert_allclose(table.theta, np.deg2rad([30, 0]))
    np.testing.assert_allclose(table.d, [0.1, 0.5])
    np.testing.assert_allclose(table.alpha, np.deg2rad([90, 0]))
    assert table.joint_types == ("continuous", "prismatic")
    assert table.name == "hand"


HEAD = "# convention: standard\nalpha,a,d,theta"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["nothing but comments", "alpha, a, d, theta"]),
        ("1,2,3,4\n", ["header", "alpha, a, d, theta"]),
        (f"{HEAD}\n0,1,2\n", ["row 1", "3 columns", "4"]),
        (f"{HEAD}\n0,1,0,0\n0,x,0,0\n", ["row 2, column 'a'", "'x'"]),
        (f"{HEAD}\n0,1,0,0\n0,nan,0,0\n", ["row 2, column 'a'", "nan"]),
        (f"{HEAD}\n0,1,,0\n", ["row 1, column 'd'", "missing"]),
        (f"{HEAD}\n", ["a header, and no joint"]),
        (f"{HEAD},colour\n0,1,0,0,red\n", ["row 1, column 'colour'", "offset"]),
        (f"{HEAD},type\n0,1,0,0,screw\n", ["row 1, column 'type'", "'screw'", "prismatic"]),
        (f"{HEAD},type\n0,1,0,0,P\n", ["row 1, column 'lower'", "prismatic", "finite"]),
        (f"{HEAD},lower,upper\n0,1,0,0,2,1\n", ["row 1, column 'lower'", "2.0", "1.0"]),
        (f"{HEAD},name\n0,1,0,0,j\n0,1,0,0,j\n", ["joint names 'j', 'j'", "2 different"]),
        (HEAD.replace("standard", "craig") + "\n0,1,0,0\n", ["'craig'", "standard", "modified"]),
        ("# angles: grad\n" + HEAD + "\n0,1,0,0\n", ["'grad'", "rad and deg"]),
        ("# tool: 1 2 3\n" + HEAD + "\n0,1,0,0\n", ["tool transform", "3 numbers", "roll"]),
        ("# base: 1 2 3 a b c\n" + HEAD + "\n0,1,0,0\n", ["base transform", "no numbers"]),
        ("alpha,a,d,theta\n0,1,0,0\n", ["# convention: standard", "--convention standard"]),
        (f"{HEAD}\n0,1,0,0\n90,1,0,0\n", ["row 2, column 'alpha'", "90 rad", "# angles: deg"]),
        (f"{HEAD},type\n0,1,0,0,R\n0,1,0,0,fixed\n", ["row 2, column 'type'", "# tool:"]),
    ],
)
def test_files_that_hold_no_table(text: str, words: list[str], tmp_path: Path) -> None:
    """The error names row, column and value, and what would be valid."""
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(UrdfError) as caught:
        DHTable.read(path)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize(
    ("rows", "options", "words"),
    [
        (np.zeros((0, 4)), {}, ["no rows"]),
        (np.zeros((2, 4)), {"joint_types": "RRP"}, ["3 joint types", "2 rows"]),
        (np.zeros((2, 4)), {"joint_types": "RX"}, ["row 2, column 'type'", "'X'"]),
        (np.zeros((2, 4)), {"joint_names": ["a"]}, ["joint names 'a'", "2 different"]),
        (np.zeros((2, 4)), {"limits": [(0, 1)]}, ["(1, 2)", "(2, 2)"]),
        (np.zeros((2, 4)), {"limits": [(0, 1), (0, np.inf)]}, ["row 2, column 'lower'", "inf"]),
        (np.zeros((2, 4)), {"tool": np.zeros((2, 4, 4)) + np.eye(4)}, ["tool transform", "(2, 4, 4)"]),
    ],
)
def test_arrays_that_are_no_table(rows: object, options: dict[str, object], words: list[str]) -> None:
    """The error names row, column and value."""
    with pytest.raises(UrdfError) as caught:
        DHTable.from_array(rows, "standard", **options)  # type: ignore[arg-type]
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_chain_that_has_no_table() -> None:
    """A chain without joints has none; axes a little off parallel have one only when they may be snapped."""
    fixed = serial_urdf("fixed", [((0, 0, 1), (0, 0, 0))], [None])
    with pytest.raises(UrdfError, match="no movable joint"):
        DHTable.from_chain(urdf_ik.load(fixed, "base", "tool").chain)
    for angle in (3e-9, 1e-8):
        origins = [
            ((0.1, 0.2, 0.3), (0.1, 0.3, 0.2)),
            ((0.7, 0.3, 0.4), (angle, 0, 0.3)),
            ((1, 0.5, 0.3), (0.3, 0.2, 0.1)),
        ]
        nearly = urdf_ik.load(serial_urdf("nearly", origins, [(0, 0, 1), (0, 0, 1), None])).chain
        with pytest.raises(UrdfError, match=rf"axes 1 and 2 are {angle:.1e} rad off parallel.*snap={2 * angle:.0e}"):
            DHTable.from_chain(nearly)
        table = DHTable.from_chain(nearly, snap=2 * angle)
        np.testing.assert_array_equal(table.alpha[:1], [0.0])
        assert 0.1 * angle < table.deviation(nearly) < 10 * angle
    arm = urdf_ik.load("zyyzyz_6r")
    for snap in (0.6, 1.0, 1e15, -1e-9):
        with pytest.raises(UrdfError, match="a finite number of at least 0 and at most 0.5 is needed"):
            DHTable.from_chain(arm.chain, snap=snap)


# ---------------------------------------------------------------- links


@pytest.mark.parametrize("name", ["dh_6r", "zyyzyz_6r"])
def test_links_can_be_seen_and_collided(name: str) -> None:
    """Every link has a visual; links that touch are neither neighbours nor parts of one wrist, and some do touch."""
    arm = urdf_ik.load(DHTable.from_chain(urdf_ik.load(name).chain).to_urdf())
    body = arm.cell.collisions
    assert body.has_geometry
    text = arm.model.xml.decode()
    assert text.count("<collision>") >= 4
    Q = np.random.default_rng(0).uniform(*np.maximum(np.minimum(arm.limits.T, PI), -PI), (300, 6))
    share = float(np.mean(body.in_collision(Q)))
    assert 0.0 < share < 0.5
    wrist = {"link_4", "link_5", "link_6"}
    assert not [pair for q in Q for pair in body.colliding_pairs(q) if set(pair) <= wrist]
    assert not body.in_collision(np.array([0.0, -0.5, 0.8, 0.0, 0.7, 0.0]))


def test_names_are_written_as_xml() -> None:
    """Names with markup in them come back as they were, and names that clash are refused."""
    names = ['a<b>&"c"', "two--hyphens"]
    table = DHTable.from_array(np.ones((2, 4)), "standard", joint_names=names, name="<x> & --y")
    arm = urdf_ik.load(table.to_urdf("b & c", "t<ip>"))
    assert arm.joint_names == tuple(names)
    assert (arm.base, arm.tip, arm.name) == ("b & c", "t<ip>", "<x> & --y")
    with pytest.raises(UrdfError, match="different names"):
        table.to_urdf("link_1")
    with pytest.raises(UrdfError, match="tool_joint"):
        DHTable.from_array(np.ones((1, 4)), "standard", joint_names=["tool_joint"]).to_urdf()


# ---------------------------------------------------------------- the command


def test_command_there_and_back(tmp_path: Path) -> None:
    """URDF to CSV in degrees, to URDF: the arm stays the same, and the error is printed."""
    table, urdf = (str(tmp_path / name) for name in ("t.csv", "t.urdf"))
    succeed("dh", "dh_6r", "--convention", "modified", "--degrees", "-o", table)
    assert "joint_3,revolute,0.0,0.5,0.0,90.0" in Path(table).read_text()
    succeed("dh", table, "-o", urdf)
    assert "q3 +90" in Path(urdf).read_text()
    for source in (urdf, "dh_6r"):
        shown = succeed("dh", source, "--convention", "modified", "--degrees")
        assert "q3 +90" in shown and "differ from the URDF's by" in shown
    assert succeed("dh", table, "--convention", "standard") != succeed("dh", table)
    ours, theirs = Reference(Path(urdf), "base_link", "tool0"), urdf_ik.load("dh_6r")
    for q in np.random.default_rng(0).uniform(-2, 2, (5, 6)):
        np.testing.assert_allclose(ours.pose(q), theirs.fk(q), atol=1e-12)
