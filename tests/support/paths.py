"""Known joint paths, arms to move along them, and the checks that every found plan must pass."""

import arms
import arms_closed_forms
import arms_general
import coal
import numpy as np
import pinocchio as pin

import urdf_ik
from urdf_ik.paths.planned_motion import Plan


def joint_path(arm: urdf_ik.Arm, m: int, seed: int, size: float = 0.3) -> np.ndarray:
    """A smooth joint motion inside the limits, (m, n)."""
    rng = np.random.default_rng(seed)
    low, high = np.clip(arm.limits.T, -2.5, 2.5)
    middle = rng.uniform(low + 0.25 * (high - low), high - 0.25 * (high - low))
    s = np.linspace(0.0, np.pi, m)[:, None]
    waves = sum(rng.normal(size=arm.dof) * size * np.sin((k + 1) * s + rng.uniform(0, 6)) for k in range(2))
    return np.clip(middle + waves, low, high)


def between(arm: urdf_ik.Arm, plan: Plan) -> float:
    """How far the tip strays from the straight segments while the joints move linearly, m."""
    s = np.linspace(0.1, 0.9, 5)[:, None]
    before = np.floor(plan.place[:-1] + 1e-9).astype(int)
    a, b = plan.poses[before, None, :3, 3], plan.poses[np.minimum(before + 1, len(plan.poses) - 1), None, :3, 3]
    p = arm.fk((1.0 - s) * plan.motion[:-1, None] + s * plan.motion[1:, None])[..., :3, 3]
    way = b - a
    share = ((p - a) * way).sum(axis=-1, keepdims=True) / np.maximum((way * way).sum(axis=-1, keepdims=True), 1e-300)
    return float(np.linalg.norm(p - a - np.clip(share, 0.0, 1.0) * way, axis=-1).max(initial=0.0))


def check(arm: urdf_ik.Arm, plan: Plan) -> None:
    """A found plan reaches its poses by Pinocchio, keeps the limits, and stays near the straight segments."""
    assert plan.found, plan.explain()
    reference = urdf_ik.cell.pinocchio_reference.Reference(arm.model, arm.base, arm.tip)
    assert np.abs(reference.pose(plan.q) - plan.poses).max() < 1e-8
    low, high = arm.limits.T
    assert (plan.q >= low - 1e-9).all()
    assert (plan.q <= high + 1e-9).all()
    assert between(arm, plan) < plan.tolerance[0] <= 4e-3
    whole = plan.place == np.round(plan.place)
    assert np.array_equal(plan.motion[whole], plan.q)


def smooth(arm: urdf_ik.Arm, rng: np.random.Generator, size: float = 0.15) -> np.ndarray:
    """Joint vectors (600, n) of a smooth motion inside the limits, dense enough to keep to straight segments."""
    low, high = np.clip(arm.limits.T, -2.8, 2.8)
    middle = rng.uniform(low + 0.25 * (high - low), high - 0.25 * (high - low))
    s = np.linspace(0.0, np.pi, 600)[:, None]
    return np.clip(middle + rng.normal(size=arm.dof) * size * np.sin(s + rng.uniform(0.0, 6.0, arm.dof)), low, high)


def described(kind: str, seed: int) -> urdf_ik.Arm:
    """A random member of a family of the tests, or one of their other arms."""
    if kind in arms.KINDS:
        arm = arms.random_arm(kind, seed, orthogonal=seed % 3 == 1, aligned=seed % 3 == 2)
    elif kind in arms_closed_forms.KINDS:
        arm = arms.random_arm(kind, seed, kinds=arms_closed_forms.KINDS, orthogonal=seed % 3 == 1)
    elif kind == "imperfect":
        arm = arms_general.near_member(list(arms.KINDS)[seed % len(arms.KINDS)], (1e-3, 1e-5, 1e-8)[seed % 3], seed)
    else:
        arm = arms_general.unstructured(seed)
    return urdf_ik.load(arm.urdf, base="base", tip="tool")


ALL_KINDS = (*arms.KINDS, *arms_closed_forms.KINDS, "general", "imperfect")


def cost_of(q: np.ndarray) -> float:
    """Sum of squares of the steps between joint vectors (m, n)."""
    return float((np.diff(q, axis=0) ** 2).sum())


def distance_to_box(arm: urdf_ik.Arm, size: float, place: np.ndarray, motion: np.ndarray) -> float:
    """Least distance, m, of any collision body to a cube along a motion (m, n), by Pinocchio's own model and coal.

    It is asked about every 0.002 rad; the arm's first link is Pinocchio's root.
    """
    text = arm.model.xml.decode()
    model = pin.buildModelFromXML(text)
    bodies = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    data, places = model.createData(), bodies.createData()
    columns = [model.joints[model.getJointId(name)].idx_q for name in arm.joint_names]
    counts = np.maximum(1, np.ceil(np.abs(np.diff(motion, axis=0)).max(axis=1) / 0.002)).astype(int)
    samples = [
        a + (b - a) * share
        for a, b, count in zip(motion[:-1], motion[1:], counts, strict=True)
        for share in np.linspace(0.0, 1.0, count + 1)
    ]
    box, at = coal.Box(size, size, size), coal.Transform3s(place[:3, :3], place[:3, 3])
    request, least = coal.DistanceRequest(), np.inf
    for sample in samples:
        q = pin.neutral(model)
        q[columns] = sample
        pin.updateGeometryPlacements(model, data, bodies, places, q)
        for body, there in zip(bodies.geometryObjects, places.oMg, strict=True):
            here = coal.Transform3s(there.rotation, there.translation)
            least = min(least, coal.distance(body.geometry, here, box, at, request, coal.DistanceResult()))
    return float(least)
