"""Copies: every public object can be pickled and copied, and what nobody may write to stays so."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik import errors
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.kinematics import velocity
from urdf_ik.maps import workspaces

Q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]


def mimicking() -> urdf_ik.Arm:
    """A two-link arm whose second joint follows the first."""
    xml = urdf_ik.load("planar_2r").model.xml.decode()
    follows = '<child link="link_2"/><mimic joint="joint_1" multiplier="-1"/>'
    return urdf_ik.load(xml.replace('<child link="link_2"/>', follows))


def objects() -> dict[str, Any]:
    """One of every kind that the interface gives."""
    six, seven, two = (urdf_ik.load(name) for name in ("zyyzyz_6r", "srs_7r", "planar_2r"))
    T, seven_T = six.fk(Q), seven.fk([0.1] * 7)
    world = urdf_ik.World()
    world.add("ball", urdf_ik.Sphere(0.3), urdf_ik.pose([2.4, 0.0, 1.6]))
    found = six.ik(T)
    plan = six.follow(urdf_ik.line(T, six.fk(np.array(Q) + 0.02), 4), world=world)
    model = six.cell.collisions.in_world(world).allow("link_1", "ball")
    grid = workspaces.workspace(two, voxel=0.1, orientations=2)
    tracker = six.tracker(Q, dt=0.01)
    return {
        "arm": six, "seven joints": seven, "mimicking": mimicking(), "task": two.for_task("planar position"),
        "locked": urdf_ik.load("zyyzyz_6r", locked={"joint_1": 0.2}), "free axis": six.with_free_axis("z"),
        "tool": six.with_tool(urdf_ik.pose([0, 0, 0.1]), [urdf_ik.Box((0.1, 0.1, 0.1))]), "chain": six.chain,
        "coupled chain": mimicking().chain, "model": six.model, "joint": six.model.joints[0],
        "plane": two.solver.control.plane,
        "structure": six.structure, "control": two.solver.control, "redundancy": seven.redundancy, "solutions": found,
        "batch": six.ik(np.stack([T, T])), "within limits": found.within_limits(), "turns": found.turns(),
        "solution": found[0], "sweep": seven.sweep(seven_T, 4), "world": world, "obstacle": world["ball"],
        "shapes": (urdf_ik.Box(0.1), urdf_ik.HalfSpace((0, 0, 1)), urdf_ik.Mesh("a.stl")),
        "points": urdf_ik.Points([[0, 0, 1]], 0.1), "collision model": model, "table": model.table(),
        "nearest": six.cell.nearest_pair(Q), "motions": six.motion_is_free(Q, np.array(Q) + 0.1), "plan": plan,
        "timed": plan.timed(1.0, 1.0), "no plan": six.follow(urdf_ik.line(T, urdf_ik.pose([9, 0, 0]), 3)),
        "tracker": tracker, "step": tracker.step(T), "table of an arm": urdf_ik.DHTable.from_chain(six.chain),
        "comparison": urdf_ik.compare(two, two, n=2), "report": urdf_ik.verify.crosscheck.check(two, n=2), "map": grid,
        "slice": grid.slice(), "region": workspaces.planar(two), "reference": Reference(six.model),
        "singular directions": velocity.singular_directions(six.chain, Q),
        "entry": urdf_ik.model.catalogue.resolve("planar_2r"),
    }  # fmt: skip


OBJECTS = objects()
WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda each: pickle.loads(pickle.dumps(each)), "deepcopy": copy.deepcopy, "copy": copy.copy
}  # fmt: skip


def arrays(value: Any, name: str = "") -> dict[str, Any]:
    """The arrays among an object's public attributes, and in what holds no more than these."""
    if isinstance(value, np.ndarray):
        return {name: value}
    if isinstance(value, tuple | list):
        return {k: array for i, each in enumerate(value) for k, array in arrays(each, f"{name}[{i}]").items()}
    if not type(value).__module__.startswith("urdf_ik") or name.count(".") > 1:
        return {}
    found = {}
    for attribute in dir(value):
        if not attribute.startswith("_") and attribute not in ("arm", "fixed"):
            try:
                each = getattr(value, attribute)
            except (errors.UrdfIkError, TypeError):
                continue
            if not callable(each):
                found.update(arrays(each, f"{name}.{attribute}"))
    return found


@pytest.mark.parametrize("what", OBJECTS)
@pytest.mark.parametrize("way", WAYS)
def test_copies_are_what_they_were(what: str, way: str) -> None:
    """The same type, the same numbers, and no array that can be written to where it could not."""
    original = OBJECTS[what]
    copied = WAYS[way](original)
    assert type(copied) is type(original)
    if not isinstance(original, urdf_ik.Arm | tuple):
        assert str(copied) == str(original) or " at 0x" in str(original)
    before, after = arrays(original), arrays(copied)
    assert before.keys() == after.keys()
    for name, array in before.items():
        np.testing.assert_array_equal(after[name], array, err_msg=name)
        assert array.flags.writeable or not after[name].flags.writeable, name


@pytest.mark.parametrize("way", WAYS)
def test_copies_answer_as_before(way: str) -> None:
    """Arms solve, collision models keep their changes and their world, trackers go on, plans have alternatives."""
    for what in ("arm", "tool", "free axis", "locked"):
        arm = OBJECTS[what]
        T = arm.fk(np.zeros(arm.dof) + 0.3)
        np.testing.assert_array_equal(WAYS[way](arm).ik(T).q, arm.ik(T).q)
    model, again = OBJECTS["collision model"], WAYS[way](OBJECTS["collision model"])
    assert dict(again.allowed_pairs) == dict(model.allowed_pairs) and again.checked_pairs == model.checked_pairs
    assert again.distance(Q) == model.distance(Q) and again.world.names == ("ball",)
    arm = OBJECTS["arm"].with_cell(OBJECTS["arm"].cell.with_collisions(model))
    assert "ball" in {name for pair in WAYS[way](arm).cell.collisions.checked_pairs for name in pair}
    assert [plan.cost for plan in WAYS[way](OBJECTS["plan"]).alternatives] == [
        plan.cost for plan in OBJECTS["plan"].alternatives
    ]
    if way != "copy":
        tracker = OBJECTS["tracker"]
        other = WAYS[way](tracker)
        np.testing.assert_array_equal(other.q, tracker.q)
        assert other.step(OBJECTS["arm"].fk(Q)).status == "ok"


@pytest.mark.parametrize("way", WAYS)
def test_errors_are_copied_with_their_fields(way: str) -> None:
    """As they come out of another process."""
    for error in (
        errors.UrdfError("p", source="s", line=3, element="e", hint="h"), errors.ChainError("c", ["a"]),
        errors.PoseError("p", (1,)), errors.MissingPackage("m"),
    ):  # fmt: skip
        again = WAYS[way](error)
        assert type(again) is type(error) and str(again) == str(error) and vars(again) == vars(error)
