"""Degenerate arms (joints on one axis, zero lengths, many parallel axes): no pose that they reach is lost."""

import re
from dataclasses import dataclass

import numpy as np
import pytest
from arms import X, Y, Z
from arms_degenerate import planted, random_degenerate
from arms_few import few_urdf
from cases import Array, thinned
from lxml import etree

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm, UrdfIkError
from urdf_ik.kinematics.structure import analyse

RESIDUAL = 1e-9


@dataclass(frozen=True)
class Described:
    """Axes, and points on them, of joints that turn (R) or slide (P)."""

    kinds: str
    axes: tuple[Array, ...]
    points: tuple[tuple[float, float, float], ...]

    def text(self, rng: np.random.Generator) -> str:
        """URDF text, with frames anywhere on the axes."""
        points = np.array(self.points)
        axes = np.array(self.axes, dtype=np.float64)
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        return few_urdf(self.kinds, axes, points, points[-1] + rng.uniform(0.05, 0.2, 3), rng)


S = X + 0.4 * Y + 0.2 * Z  # a skew direction
SEVEN = {
    "axes 5 and 6 are one": Described(
        "RRRRRRR",
        (Z, Y, X + Z, Y, X, X, Z + Y),
        ((0, 0, 0), (0, 0, 0.3), (0.1, 0, 0.6), (0.1, 0.1, 0.9), (0.2, 0, 1), (0.5, 0, 1), (0.5, 0.1, 1)),
    ),
    "axes 3 and 4 are one, the other way round": Described(
        "RRRRRRR",
        (Z, Y, X, -X, Y, X + Z, S),
        ((0, 0, 0), (0, 0, 0.3), (0.1, 0, 0.6), (0.2, 0, 0.6), (0.3, 0, 0.6), (0.5, 0.2, 0.7), (0.6, 0.1, 0.8)),
    ),
    "slides 3 and 4 are one": Described(
        "RRPPRRR",
        (Z, Y, X, X, Y, X + Z, S),
        ((0, 0, 0), (0, 0, 0.3), (0.1, 0, 0.6), (0.2, 0, 0.9), (0.3, 0, 0.6), (0.5, 0.2, 0.7), (0.6, 0.1, 0.8)),
    ),
    "axes 2 to 5 are parallel": Described(
        "RRRRRRR",
        (Z, Y, Y, Y, Y, X, S),
        ((0, 0, 0), (0, 0, 0.3), (0.3, 0, 0.4), (0.5, 0, 0.7), (0.8, 0.1, 0.7), (0.9, 0.2, 0.7), (1, 0.1, 0.8)),
    ),
    "axes 2 to 5 meet": Described(
        "RRRRRRR",
        (Z, Y, X, Z + Y, Y, X, S),
        ((0, 0, 0), (0.2, 0, 0.3), (0.2, 0, 0.3), (0.2, 0, 0.3), (0.2, 0, 0.3), (0.5, 0.2, 0.6), (0.7, 0.1, 0.8)),
    ),
    "of rank 5: two pairs are one": Described(
        "RRRRRRR",
        (Z, Y, Y, X, X, Y, S),
        ((0, 0, 0), (0, 0, 0.3), (0, 0.1, 0.3), (0.3, 0, 0.4), (0.4, 0, 0.4), (0.6, 0.1, 0.7), (0.7, 0.1, 0.8)),
    ),
    "of rank 4: all meet or are parallel": Described(
        "RRRRRRR",
        (Z, Z, Z, Z, Z, Z, X),
        ((0, 0, 0), (0.1, 0, 0.3), (0.2, 0, 0.3), (0.2, 0.3, 0.3), (0.2, 0.1, 0), (0.5, 0.2, 0.6), (0.7, 0.1, 0.8)),
    ),
    "of rank 3: all meet": Described("RRRRRRR", (Z, Y, X, S, Y, Z, X), ((0, 0, 0),) * 7),
}
"""Arms with seven joints whose other six are singular everywhere when the first or the last joint is held."""


def assert_reached(arm: urdf_ik.Arm, Q: Array) -> None:
    """Each pose of the joint vectors (m, n) has an answer, exact by Pinocchio, at the value of a free parameter too."""
    reference = Reference(arm.model, arm.base, arm.tip)
    for q, T in zip(Q, reference.pose(Q), strict=True):
        value = None if arm.redundancy is None else arm.redundancy_of(q)
        found = arm.ik(T, redundancy=value)
        assert len(found), f"{arm.structure.family} at {q.tolist()}: {found.explain()}"
        assert found.explain() == ""
        reached = reference.pose(found.to_array())
        assert np.abs(reached - T)[:, :3].max() < RESIDUAL
        if arm.redundancy is not None and arm.redundancy.kind == "locked joint":
            apart = arm.redundancy_of(found.to_array()) - value
            assert np.abs(np.sin(0.5 * apart)).max() < 1e-12


@pytest.mark.parametrize("name", SEVEN)
def test_seven_joints_held_in_the_middle_lose_no_pose(name: str) -> None:
    """Where holding an end joint leaves a singular arm, one in the middle is held: no pose is lost, at any value."""
    rng = np.random.default_rng(1)
    arm = urdf_ik.load(SEVEN[name].text(rng), "base", "tool")
    assert arm.redundancy is not None
    assert_reached(arm, planted(arm, rng, 12))


@pytest.mark.parametrize("name", [name for name in SEVEN if "are one" in name and "rank" not in name])
def test_of_two_joints_with_one_axis_one_is_held(name: str) -> None:
    """All solutions have the held value, the planted one is among them, and a batch gives what each pose gives."""
    rng = np.random.default_rng(2)
    arm = urdf_ik.load(SEVEN[name].text(rng), "base", "tool")
    pair = next(pair for pair in analyse(arm.chain).pairs if pair.relation in ("coincident", "parallel"))
    assert arm.redundancy is not None
    assert arm.redundancy.joint == arm.joint_names[pair.first - 1]
    Q = planted(arm, rng, 40)[:20]
    T, values = arm.fk(Q), arm.redundancy_of(Q)
    batch = arm.ik(T, redundancy=values)
    for i, q in enumerate(Q):
        alone = arm.ik(T[i], redundancy=values[i])
        np.testing.assert_array_equal(alone.q, batch[i].q)
        apart = alone.to_array() - q
        apart[:, ~arm.chain.prismatic] = np.remainder(apart[:, ~arm.chain.prismatic] + np.pi, 2.0 * np.pi) - np.pi
        assert np.abs(apart).max(axis=1).min() < 1e-7
        assert np.abs(alone.to_array()[:, ~arm.chain.prismatic]).max() <= np.pi


def test_axes_2_to_5_parallel_with_one_held_finds_the_planted_vector() -> None:
    """With one of four parallel axes held, the planted joint vector is found at its value and not marked singular."""
    rng = np.random.default_rng(3)
    arm = urdf_ik.load(SEVEN["axes 2 to 5 are parallel"].text(rng), "base", "tool")
    assert arm.redundancy is not None
    for q in planted(arm, rng, 24)[:12]:
        found = arm.ik(arm.fk(q), redundancy=arm.redundancy_of(q))
        apart = np.abs(np.remainder(found.q - q + np.pi, 2.0 * np.pi) - np.pi).max(axis=-1)
        assert np.nanmin(apart) < 1e-7
        assert found.singular[int(np.nanargmin(apart))] == 0
        assert not found.certain


STRIPPED = ("xyz", "rpy", "xyz rpy")


def without_origins(text: bytes, joint: str, what: str) -> str:
    """URDF text in which the ``<origin>`` of a joint lacks these attributes."""
    tree = etree.fromstring(text)
    origin = next(each for each in tree.iter("joint") if each.get("name") == joint).find("origin")
    if origin is not None:
        for name in what.split():
            origin.attrib.pop(name, None)
    return etree.tostring(tree).decode()


@pytest.mark.parametrize(
    "name", thinned(["puma_560", "zyyzyz_6r", "ur5", "srs_7r", "stanford_rrprrr", "scara_rrpr"], 3)
)
def test_catalogue_arms_without_an_origin(name: str) -> None:
    """With each joint's ``<origin>`` left out, or half of it, no pose is lost, or the refusal names the joints."""
    whole, rng = urdf_ik.load(name), np.random.default_rng(4)
    for joint in whole.joint_names:
        for what in STRIPPED:
            arm = urdf_ik.load(without_origins(whole.model.xml, joint, what), whole.base, whole.tip)
            try:
                assert_reached(arm, planted(arm, rng, 4))
            except UnsupportedArm as error:
                assert "redundant" in str(error)
                assert sum(re.search(rf"\b{each}\b", str(error)) is not None for each in arm.joint_names) >= 2


@pytest.mark.parametrize("length", thinned([0.0, 1e-18, 1e-16, 1e-12, 1e-9, 1e-7], 3))
@pytest.mark.parametrize("step", thinned(range(1, 6), 2))
def test_tiny_lengths(step: int, length: float) -> None:
    """A step of 0 to 1e-7 m between two axes of a 6R arm, parallel ones too, loses no pose."""
    rng = np.random.default_rng(5)
    for axes in ((Z, Y, Y, X, Y, X), (Z, Y, X, Y, X, Y), (Z, Z, Y, X, Y, X), (Z, Y, Y, Y, X, Y)):
        points = np.cumsum(rng.uniform(0.1, 0.4, (6, 3)), axis=0)
        points[step:] += points[step - 1] - points[step] + length
        arm = urdf_ik.load(few_urdf("RRRRRR", np.array(axes), points, points[-1] + 0.1, rng), "base", "tool")
        assert_reached(arm, planted(arm, rng, 3))


@pytest.mark.parametrize("count", [20, pytest.param(120, marks=pytest.mark.slow)])
def test_random_degenerate_arms(count: int) -> None:
    """Of random degenerate arms no pose is lost, and an arm that is not solved is refused as UnsupportedArm."""
    solved = 0
    for seed in range(count):
        rng = np.random.default_rng([7, seed])
        arm = urdf_ik.load(random_degenerate(rng), "base", "tool")
        try:
            assert_reached(arm, planted(arm, rng, 3))
            solved += 1
        except UrdfIkError as error:
            assert isinstance(error, UnsupportedArm), f"seed {seed}: {error}"
    assert solved > count // 2
