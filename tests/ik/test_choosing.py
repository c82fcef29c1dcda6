"""Which solution is chosen: by distance, within bounds, by quality, against a search through all turns one by one."""

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from arms import random_arm
from cases import from_catalogue, thinned
from numpy.typing import NDArray
from oracle import Oracle

import urdf_ik
from urdf_ik import ArgumentError
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.model import catalogue

Array = NDArray[np.float64]

ROUND = np.pi / 2.0 * np.array([-4, -3, -2, -1, 0, 1, 2, 3, 4])
ARMS = ("ur5", "ur5_limited", "zyyzyz_6r", "puma_560")
WEIGHTS = np.array([1.0, 4.0, 0.5, 0.0, 2.0, 1.0])
CHOICES: tuple[dict[str, Any], ...] = (
    {},
    {"metric": "max"},
    {"metric": "time"},
    {"weights": WEIGHTS},
    {"metric": "max", "weights": WEIGHTS},
    {"metric": "time", "weights": WEIGHTS},
    {"within": 2.5},
    {"metric": "max", "within": [0.8, 1.0, 3.0, np.inf, 1.5, 6.0]},
)


def distances(arm: urdf_ik.Arm, apart: Array, choice: dict[str, Any]) -> Array:
    """(k,) of differences (k, n), infinite where a joint is further away than it may be."""
    model = Reference(arm.model, arm.base, arm.tip).pin_model
    weights = choice.get("weights", np.ones(arm.dof))
    if choice.get("metric", "l2") == "l2":
        out = np.sqrt((weights * apart**2).sum(axis=1))
    else:
        speeds = np.array([model.velocityLimit[model.joints[model.getJointId(j)].idx_v] for j in arm.joint_names])
        out = np.max(weights * np.abs(apart) / (speeds if choice["metric"] == "time" else 1.0), axis=1)
    return np.where((np.abs(apart) <= np.add(choice.get("within", np.inf), 1e-9)).all(axis=1), out, np.inf)


def vectors(arm: urdf_ik.Arm, count: int, seed: int, *, of_round_values: bool) -> Array:
    """Joint vectors (count, n) inside the limits, random or at multiples of 90 degrees."""
    rng = np.random.default_rng(seed)
    lower, upper = np.clip(arm.limits, -2.0 * np.pi, 2.0 * np.pi).T
    drawn = rng.uniform(lower, upper, (count, arm.dof))
    return np.clip(rng.choice(ROUND, (count, arm.dof)), lower, upper) if of_round_values else drawn


@pytest.mark.parametrize("of_round_values", [False, True])
@pytest.mark.parametrize("choice", CHOICES, ids=str)
@pytest.mark.parametrize("name", thinned(ARMS, 2))
def test_nearest_of_all_turns(name: str, choice: dict[str, Any], of_round_values: bool) -> None:
    """No image inside the limits is nearer; where no image is within the bounds, nothing is returned."""
    arm = from_catalogue(name).arm
    planted = vectors(arm, 12, 1, of_round_values=of_round_values)
    references = vectors(arm, 12, 2, of_round_values=of_round_values)
    references[:4] = planted[:4] + 0.1
    batch = arm.ik(arm.fk(planted)).nearest(references, within_limits=True, **choice)
    for k, q_ref in enumerate(references):
        s = arm.ik(arm.fk(planted[k]))
        least = distances(arm, s.turns().to_array() - q_ref, choice).min(initial=np.inf)
        found = s.nearest(q_ref, within_limits=True, **choice)
        assert len(found) == int(np.isfinite(least))
        np.testing.assert_array_equal(batch[k].q, found.q)
        if found:
            assert distances(arm, found.to_array() - q_ref, choice)[0] == pytest.approx(least, abs=1e-9)
            assert (np.abs(found.to_array() - np.clip(found.to_array(), *arm.limits.T)) <= 1e-9).all()
            listed = s.turns().nearest(q_ref, **choice).to_array()
            assert distances(arm, listed - q_ref, choice)[0] == pytest.approx(least, abs=1e-9)
    if not of_round_values:  # which are singular: what stands for a continuum may be far away
        assert batch[:4].valid.all()


@pytest.mark.parametrize("choice", CHOICES, ids=str)
def test_modulo_turns_angles_go_round(choice: dict[str, Any]) -> None:
    """A difference of angles is the shorter way round where that is asked for, in every metric."""
    arm = from_catalogue("ur5").arm
    rng = np.random.default_rng(3)
    for q in rng.uniform(-np.pi, np.pi, (20, 6)):
        s = arm.ik(arm.fk(q))
        q_ref = rng.uniform(-9.0, 9.0, 6)
        apart = np.angle(np.exp(1j * (s.to_array() - q_ref)))
        expected = np.sort(distances(arm, apart, choice))
        found = s.nearest(q_ref, n=3, modulo_turns=True, **choice).to_array()
        assert len(found) == min(3, np.isfinite(expected).sum())
        got = distances(arm, np.angle(np.exp(1j * (found - q_ref))), choice)
        np.testing.assert_allclose(got, expected[: len(found)], atol=1e-9)


@pytest.mark.parametrize("q_ref", [[3.6, 0.3, 0.5, -3.5, 0.8, 4.0], [-3.2, -0.5, -3.0, 5.9, -1.0, -6.0]])
def test_an_arm_at_its_own_pose_does_not_turn(q_ref: list[float]) -> None:
    """An arm that stands more than half a turn from zero, inside limits of a turn each way, stays where it is."""
    arm = from_catalogue("ur5").arm
    T = arm.fk(q_ref)
    near = (
        arm.ik(T).nearest(q_ref, within=0.1),
        arm.ik(T).within_limits().nearest(q_ref, within=0.1),
        arm.ik(T).turns().nearest(q_ref, within=0.1),
        arm.ik_nearest(T, q_ref, within=0.1),
        arm.ik_nearest(T, q_ref, within=0.1, within_limits=False),
    )
    for found in near:
        assert np.abs(found.q[0] - q_ref).max() < 1e-9
        assert np.abs(found.difference(q_ref)).max() < 1e-9


def test_bounds_apply_to_turns_and_batches() -> None:
    """Bounds apply to turns and to batches; a chosen solution keeps its branch."""
    arm = from_catalogue("ur5").arm
    q = np.array([0.3, -1.0, 1.2, -0.7, 0.9, -0.5])
    s = arm.ik(arm.fk(np.stack([q, q + 0.1])))
    found = s.nearest(q, within=0.05)
    assert found.count.tolist() == [1, 0]
    assert found.filters == ("within", "nearest")
    assert found.names[0, 0] == s.names[0, int(np.argmin(np.abs(s.q[0] - q).max(axis=1)))]
    turned = s.turns().nearest(q - [2.0 * np.pi, 0, 0, 0, 0, 0], within=0.05, n=4)
    assert turned[0][0].branch.endswith("[q1-360°]") and turned.count.tolist() == [1, 0]
    assert found[0].explain() == ""


def test_ur5_elbow_beyond_its_bound_is_named() -> None:
    """The reason names the closest solution's joint that is too far away, its distance, and the bound."""
    arm = from_catalogue("ur5").arm
    q = np.array([0.3, -1.0, 1.2, -0.7, 0.9, -0.5])
    near = q + [0.0, 0.0, 0.25, 0.0, 0.0, 0.0]
    found = arm.ik(arm.fk(q)).nearest(near, within=0.2, within_limits=True)
    text = found.explain()
    assert "8 solutions reach the pose inside the joint limits, none as near to the reference as asked" in text
    assert text.endswith("has 'elbow_joint' 0.25 rad from it, where 0.2 is allowed")
    assert arm.ik_nearest(arm.fk(q), near, within=0.2).explain() == text


def test_time_needs_speeds() -> None:
    """Without a joint's speed in the URDF the time metric is refused; the message names the joint and a remedy."""
    text = random_arm("wrist, 1x2", 0).urdf.replace('velocity="', 'velocity="0" was="', 1)
    arm = urdf_ik.load(text, "base", "tool")
    with pytest.raises(ArgumentError, match=r"'joint_1'.*velocity=.*weights of 1 / speed"):
        arm.ik(np.eye(4)).nearest(np.zeros(6), metric="time")


@pytest.mark.parametrize("name", ARMS)
def test_best_within_the_limits(name: str) -> None:
    """None of the images inside the limits is farther from them, the least joint's share of half its range counted."""
    arm = from_catalogue(name).arm
    lower, upper = arm.limits.T

    def margins(q: Array) -> Array:
        return (np.minimum(q - lower, upper - q) / (0.5 * (upper - lower))).min(axis=-1)

    for q in vectors(arm, 10, 4, of_round_values=False):
        s = arm.ik(arm.fk(q))
        best = s.best("limits")
        assert best.filters == ("limits", "best") and best.branches == ("best",)
        assert margins(best[0].q) == pytest.approx(margins(s.turns().to_array()).max(), abs=1e-12)
        np.testing.assert_allclose(s.turns().best("limits").to_array(), best.to_array())
        np.testing.assert_allclose(best.scores("limits"), arm.limit_margin(best.q), atol=0.0)
        assert margins(q) == pytest.approx(float(arm.limit_margin(q)))


def test_best_by_manipulability() -> None:
    """Solutions are ordered by the manipulability of Pinocchio's Jacobians; a pose without solutions stays empty."""
    arm = from_catalogue("ur5").arm
    model = pin.buildModelFromXML(arm.model.xml.decode())
    data, frame = model.createData(), model.getFrameId(arm.tip)

    def volume(q: Array) -> float:
        J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
        return float(np.sqrt(max(np.linalg.det(J @ J.T), 0.0)))

    q = vectors(arm, 6, 5, of_round_values=False)
    T = arm.fk(q)
    T[5, :3, 3] += 9.0
    s = arm.ik(T)
    best = s.best("manipulability", n=3)
    assert best.branches == ("best", "best 2", "best 3")
    assert best.count.tolist() == [3, 3, 3, 3, 3, 0]
    for k in range(5):
        expected = sorted((volume(one.q) for one in s[k]), reverse=True)[:3]
        assert [volume(one.q) for one in best[k]] == pytest.approx(expected, abs=1e-9)
    scores = s.scores("manipulability")
    assert (np.isnan(scores) == ~s.valid).all()


def test_planar_2r_best_has_manipulability_l1_l2_sin_q2() -> None:
    """An arm that controls a position only is rated by the translation: of two links, l1 l2 |sin q2|."""
    arm = urdf_ik.load("planar_2r_unit")
    s = arm.ik(arm.solver.control.target_of(arm.fk([0.4, 1.1])), task="planar position")
    np.testing.assert_allclose(s.scores("manipulability")[s.valid], np.abs(np.sin(s.to_array()[:, 1])), atol=1e-12)


@pytest.mark.parametrize("choice", CHOICES, ids=str)
def test_every_arm_takes_the_same_options(choice: dict[str, Any]) -> None:
    """With six joints and with a task, ``ik_nearest`` is ``nearest`` of all solutions, for every option."""
    arm = from_catalogue("ur5").arm
    q = vectors(arm, 5, 6, of_round_values=False)
    np.testing.assert_array_equal(
        arm.ik_nearest(arm.fk(q), q + 0.2, **choice).q,
        arm.ik(arm.fk(q)).nearest(q + 0.2, within_limits=True, **choice).q,
    )
    two = urdf_ik.load("planar_2r")
    options = {key: value for key, value in choice.items() if np.isscalar(value)}
    target = two.solver.control.target_of(two.fk([0.3, -0.8]))
    for asked in (two, two.for_task("planar position")):
        found = asked.ik_nearest(target, [0.3, -0.8], task="planar position", **options)
        np.testing.assert_allclose(found[0].q, [0.3, -0.8], atol=1e-9)


def test_best_by_clearance() -> None:
    """The order is that of coal's distances, of the links alone and of a box beside the arm."""
    arm = from_catalogue("ur5").arm
    world = urdf_ik.World()
    world.add("box", urdf_ik.Box((0.2, 0.2, 0.2)), urdf_ik.pose([0.6, 0.5, 0.3]))
    s = arm.ik(arm.fk([0.3, -1.0, 1.2, -0.7, 0.9, -0.5]))
    for cell in (None, world):
        expected = [float(arm.clearance(one.q, cell)) for one in s]
        best = s.best("clearance", n=2, world=cell)
        assert [float(arm.clearance(one.q, cell)) for one in best] == sorted(expected, reverse=True)[:2]
        np.testing.assert_allclose(s.scores("clearance", world=cell)[s.valid], expected, atol=1e-12)


@pytest.mark.parametrize("name", ["zyyzyz_6r", "ur5", "puma_560"])
def test_a_continuum_is_taken_near_each_reference(name: str) -> None:
    """At poses with a stretched wrist each of a batch is solved near its own reference, as it is alone."""
    arm = from_catalogue(name).arm
    planted = vectors(arm, 8, 7, of_round_values=False)
    planted[::2, 4] = 0.0
    T = arm.fk(planted)
    found = arm.ik_nearest(T, planted)
    np.testing.assert_allclose(found.q[:, 0], planted, atol=1e-6)
    assert found.singular[::2].any()
    np.testing.assert_array_equal(arm.ik_nearest(T[:, None], planted[:, None]).q[:, 0], found.q)
    for k, q in enumerate(planted):
        np.testing.assert_array_equal(arm.ik_nearest(T[k], q).q, found[k].q)
    with pytest.raises(ArgumentError, match="one a pose"):
        arm.ik_nearest(T, planted[:3])


@pytest.mark.parametrize("place", [None, (0.1, -0.3, 0.4)])
def test_a_wish_for_the_elbow(place: tuple[float, float, float] | None) -> None:
    """By Pinocchio's heights and distances no value of the redundancy parameter has a better elbow."""
    case = from_catalogue("srs_7r")
    arm = case.arm
    link = arm.chain.links[4]
    elbow = Oracle(catalogue.resolve("srs_7r").path, arm.base, link)

    def score(q: Array) -> float:
        at = elbow.pose(q[: elbow.dof])[:3, 3]
        return float(at[2]) if place is None else -float(np.linalg.norm(at - place))

    T = case.oracle.pose(np.array([0.3, -0.5, 0.8, 1.4, 0.7, -0.2, 0.1]))
    wish = urdf_ik.Wish(link, place)
    best = arm.ik(T).best(wish)
    others = arm.ik(np.tile(T, (400, 1, 1)), redundancy=np.linspace(-np.pi, np.pi, 400)).within_limits()
    assert len(best.within_limits()) == 1
    assert best.scores(wish)[0] == pytest.approx(score(best[0].q), abs=1e-9)
    assert score(best[0].q) > max(score(q) for q in others.q[others.valid]) - 1e-9
    placed = arm.for_task("position").ik(T).best(wish)
    assert len(placed) == 1 and np.linalg.norm(case.oracle.pose(placed[0].q)[:3, 3] - T[:3, 3]) < 1e-9
    with pytest.raises(ArgumentError, match="no link is called 'elbow'"):
        arm.ik(T).best(urdf_ik.Wish("elbow"))
